use super::*;
use std::collections::VecDeque;
use std::io::{self, Cursor};

fn address() -> Address {
    "s7://192.168.0.1/0/2/DB41".parse().unwrap()
}

#[test]
fn a_plc_that_sends_a_byte_now_and_then_has_no_more_time_than_another() {
    let begin = Instant::now();
    let until = begin + PATIENCE;
    let after = |tenths: u32| left(until, begin + PATIENCE * tenths / 10).map_err(|error| error.kind());
    assert_eq!([after(0), after(5), after(9)], [Ok(PATIENCE), Ok(PATIENCE / 2), Ok(PATIENCE / 10)]);
    assert_eq!([after(10), after(11)], [Err(ErrorKind::TimedOut); 2]);
}

/// A PLC that gives these answers, in this order, whatever it is asked. At the end it closes the connection.
struct Plc {
    answers: VecDeque<Vec<u8>>,
    sending: Cursor<Vec<u8>>,
    asked: Vec<Vec<u8>>,
}

impl Read for Plc {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.sending.read(bytes)
    }
}

impl Write for Plc {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.asked.push(bytes.to_vec());
        self.sending = Cursor::new(self.answers.pop_front().unwrap_or_default());
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A message around a TPDU.
fn message(tpdu: &[u8]) -> Vec<u8> {
    let mut message = vec![3, 0, 0, tpdu.len() as u8 + 4];
    message.extend(tpdu);
    message
}

/// An acknowledgement with these parameters and data.
fn acknowledgement(error: [u8; 2], parameters: &[u8], data: &[u8]) -> Vec<u8> {
    let mut tpdu = vec![2, 0xF0, 0x80, 0x32, 3, 0, 0, 0, 1, 0, parameters.len() as u8, 0, data.len() as u8];
    tpdu.extend(error);
    tpdu.extend(parameters);
    tpdu.extend(data);
    message(&tpdu)
}

fn confirmed() -> Vec<u8> {
    message(&[17, 0xD0, 0, 1, 0, 1, 0, 0xC0, 1, 0x0A, 0xC1, 2, 1, 0, 0xC2, 2, 1, 2])
}

fn granted(longest: u16) -> Vec<u8> {
    let longest = longest.to_be_bytes();
    acknowledgement([0, 0], &[0xF0, 0, 0, 1, 0, 1, longest[0], longest[1]], &[])
}

fn item(code: u8, bytes: &[u8]) -> Vec<u8> {
    let mut data = vec![code, 4, 0, bytes.len() as u8 * 8];
    data.extend(bytes);
    acknowledgement([0, 0], &[4, 1], &data)
}

/// Reads 4 bytes from byte 20 on of a PLC that gives these answers.
fn answered(answers: Vec<Vec<u8>>) -> (Result<Vec<u8>>, Vec<Vec<u8>>) {
    let mut plc = Plc { answers: answers.into(), sending: Cursor::default(), asked: Vec::new() };
    (read(&mut plc, &address(), 20, 4), plc.asked)
}

fn refused(answers: Vec<Vec<u8>>) -> String {
    format!("{:#}", answered(answers).0.unwrap_err())
}

#[test]
fn an_address_names_host_rack_slot_and_data_block() {
    let expected = Address { host: "192.168.0.1".into(), port: 102, rack: 0, slot: 2, number: 41 };
    assert_eq!(address(), expected);
    assert_eq!("S7://192.168.0.1/0/2/db41".parse::<Address>().unwrap(), expected);
    for text in ["s7://192.168.0.1/0/2/DB41", "s7://plc.local:1102/1/3/DB7"] {
        assert_eq!(text.parse::<Address>().unwrap().to_string(), text);
    }
}

#[test]
fn a_wrong_address_is_refused_with_an_example() {
    for (text, sentence) in [
        ("s7://192.168.0.1", "is not the address of a data block: write s7://HOST/RACK/SLOT/DBn"),
        ("s7://192.168.0.1/0/2/DB41/4", "is not the address of a data block"),
        ("s7:///0/2/DB41", "has no host"),
        ("s7://plc:x/0/2/DB41", "\"x\" is not a TCP port"),
        ("s7://plc/8/2/DB41", "\"8\" is not a rack (0 to 7)"),
        ("s7://plc/0/32/DB41", "\"32\" is not a slot (0 to 31)"),
        ("s7://plc/0/2/TIC101", "\"TIC101\" is not a data block such as DB41"),
        ("s7://plc/0/2/DB0", "\"DB0\" is not a data block such as DB41"),
        ("s7://plc/0/2/ä", "\"ä\" is not a data block such as DB41"),
    ] {
        let error = text.parse::<Address>().unwrap_err().to_string();
        assert!(error.contains(sentence), "{error}");
    }
}

#[test]
fn the_bytes_are_read_in_one_request_and_nothing_is_written() {
    let (bytes, asked) = answered(vec![confirmed(), granted(240), item(0xFF, &[0x40, 0, 0, 0])]);
    assert_eq!(bytes.unwrap(), [0x40, 0, 0, 0]);
    assert_eq!(asked.len(), 3);
    // Rack 0 and slot 2 in the called TSAP.
    assert_eq!(asked[0][18..], [0xC2, 2, 1, 2]);
    assert_eq!(
        asked[2],
        [
            3, 0, 0, 31, 2, 0xF0, 0x80, 0x32, 1, 0, 0, 0, 2, 0, 14, 0, 0, 4, 1, 0x12, 10, 0x10, 2, 0, 4, 0, 41, 0x84,
            0, 0, 160
        ],
        "read variable (4), 4 bytes of DB41 from bit 160 on"
    );
}

#[test]
fn every_refusal_of_an_item_is_a_sentence() {
    for (code, sentence) in [
        (0x03, "the PLC denies access to DB41: lower the protection level"),
        (
            0x05,
            "DB41 is shorter than 24 bytes, so it is not an instance of this block, or it is an optimized data block",
        ),
        (0x06, "cannot read bytes of DB41 (code 0x06)"),
        (0x0A, "no DB41 in the PLC, or it is an optimized data block"),
        (0x77, "refuses to read DB41 (code 0x77)"),
    ] {
        let error = refused(vec![confirmed(), granted(240), item(code, &[])]);
        assert!(error.contains(sentence), "{error}");
    }
}

#[test]
fn every_refusal_of_a_request_is_a_sentence() {
    for (error, sentence) in [
        ([0x81, 0x04], "tick \"Permit access with PUT/GET communication from remote partner\""),
        ([0xD2, 0x41], "denies access by its protection level"),
        ([0x12, 0x34], "(error class 0x12, code 0x34)"),
    ] {
        let error = refused(vec![confirmed(), granted(240), acknowledgement(error, &[], &[])]);
        assert!(error.contains(sentence), "{error}");
    }
}

#[test]
fn a_wrong_rack_or_slot_is_said() {
    let disconnect = message(&[6, 0x80, 0, 0, 0, 0, 0]);
    for answers in [vec![disconnect], vec![]] {
        let error = refused(answers);
        assert!(error.starts_with("no CPU in rack 0, slot 2, or it accepts no connections"), "{error}");
    }
}

#[test]
fn a_connection_that_ends_early_is_said() {
    assert_eq!(
        refused(vec![confirmed()]),
        "the PLC may have no free connection; close another programming device or panel: the PLC closed the connection"
    );
    assert_eq!(refused(vec![confirmed(), granted(240)]), "the PLC closed the connection");
}

#[test]
fn what_does_not_fit_into_one_answer_is_refused() {
    let error = refused(vec![confirmed(), granted(21)]);
    assert!(error.starts_with("the block needs 4 bytes, but the PLC sends at most 3 in one answer"), "{error}");
    let error = refused(vec![confirmed(), granted(22), item(0xFF, &[1, 2, 3])]);
    assert_eq!(error, "the PLC sent 3 bytes instead of 4: DB41 is too short");
}

#[test]
fn an_answer_of_another_protocol_is_refused_wherever_it_is_cut() {
    let web = b"HTTP/1.1 400 Bad Request\r\n\r\n".to_vec();
    assert!(refused(vec![web]).ends_with(NO_S7));
    let good = item(0xFF, &[0x40, 0, 0, 0]);
    for length in 5..good.len() {
        let mut cut = good[..length].to_vec();
        cut[3] = length as u8;
        refused(vec![confirmed(), granted(240), cut]);
    }
    for place in 0..good.len() {
        for value in [0, 1, 0x7F, 0xFF] {
            let mut changed = good.clone();
            changed[place] = value;
            // It is refused or read, and does not panic.
            let _ = answered(vec![confirmed(), granted(240), changed]);
        }
    }
}

#[test]
fn an_address_of_ipv6_stands_in_brackets() {
    for (text, port) in [("s7://[::1]/0/2/DB41", PORT), ("s7://[::1]:1102/0/2/DB41", 1102)] {
        let address: Address = text.parse().unwrap();
        assert_eq!((address.host.as_str(), address.port), ("::1", port));
        assert_eq!(address.to_string(), text);
    }
}
