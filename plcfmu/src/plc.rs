//! Data blocks of a Siemens S7, read over the network.
//!
//! Uses S7 communication over ISO on TCP (RFC 1006), read-only, with a single request, so that all bytes are from the
//! same moment. By design, no function writes to a PLC: values go back as a source that an engineer loads.
//!
//! The crate `rust7` can also read data blocks, but it reports only two of the PLC's error codes, although the code
//! determines which PLC setting the user has to change, and it treats an answer that arrives in two pieces as a
//! refusal.

use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use parameters::{BlockType, layout};
use std::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::str::FromStr;
use std::time::{Duration, Instant};

/// How long to wait for a connection, and then for all answers together.
const PATIENCE: Duration = Duration::from_secs(5);

/// The port of S7 communication.
const PORT: u16 = 102;

/// The maximum PDU length requested, in bytes. An S7 may grant less, but always at least 240.
const LONGEST_PDU: u16 = 480;

/// The bytes of a PDU in addition to those of the data block: header, parameters and the item's header.
const OVERHEAD: usize = 18;

/// A data block of a PLC: `s7://HOST[:PORT]/RACK/SLOT/DBn`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    /// The PLC's name or IP address.
    pub host: String,
    /// The TCP port, 102 for every real PLC.
    pub port: u16,
    /// The rack of the CPU, 0 ... 7.
    pub rack: u8,
    /// The slot of the CPU, 0 ... 31.
    pub slot: u8,
    /// The number of the data block.
    pub number: u16,
}

impl FromStr for Address {
    type Err = Error;

    fn from_str(text: &str) -> Result<Address> {
        const EXAMPLE: &str = "write s7://HOST/RACK/SLOT/DBn, such as s7://192.168.0.1/0/2/DB41";
        let parts = text.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case("s7://"));
        let parts: Vec<&str> = parts.map(|_| text[5..].split('/').collect()).unwrap_or_default();
        let [host, rack, slot, block] = parts[..] else {
            bail!("{text:?} is not the address of a data block: {EXAMPLE}");
        };
        // An IPv6 address contains colons and is written in brackets.
        let (host, port) = match host.strip_prefix('[').and_then(|host| host.split_once(']')) {
            Some((host, port)) => (host, port.strip_prefix(':')),
            None => host.split_once(':').map_or((host, None), |(host, port)| (host, Some(port))),
        };
        let port = port.map(|port| port.parse().map_err(|_| anyhow!("{text:?}: {port:?} is not a TCP port")));
        let port = port.unwrap_or(Ok(PORT))?;
        ensure!(!host.is_empty(), "{text:?} has no host: {EXAMPLE}");
        let small = |what: &str, number: &str, highest: u8| match number.parse() {
            Ok(number) if number <= highest => Ok(number),
            _ => Err(anyhow!("{text:?}: {number:?} is not a {what} (0 to {highest}): {EXAMPLE}")),
        };
        let number = block
            .get(..2)
            .filter(|prefix| prefix.eq_ignore_ascii_case("DB"))
            .and_then(|_| block[2..].trim_start().parse().ok())
            .filter(|number| *number > 0);
        let number = number.with_context(|| {
            format!(
                "{text:?}: {block:?} is not a data block such as DB41; a PLC identifies data blocks by number, not by symbol"
            )
        })?;
        Ok(Address { host: host.into(), port, rack: small("rack", rack, 7)?, slot: small("slot", slot, 31)?, number })
    }
}

impl fmt::Display for Address {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let Address { host, port, rack, slot, number } = self;
        let host = if host.contains(':') { format!("[{host}]") } else { host.clone() };
        match *port {
            PORT => write!(formatter, "s7://{host}/{rack}/{slot}/DB{number}"),
            port => write!(formatter, "s7://{host}:{port}/{rack}/{slot}/DB{number}"),
        }
    }
}

/// Reads an instance of the block that begins at byte `offset` of the data block. Returns the data block up to the last
/// member in the block's table, so that each member is at its address; the bytes before the instance are not read and
/// are 0.
///
/// # Errors
/// The PLC cannot be reached, or refuses the request; the error states why and, for a refusal, which setting to change.
pub fn fetch(address: &Address, block: &BlockType, offset: usize) -> Result<Vec<u8>> {
    let (_, length) = layout::addresses(block);
    let mut bytes = vec![0; offset];
    bytes.extend(fetch_from(address, offset, length).with_context(|| address.to_string())?);
    Ok(bytes)
}

/// Reads the first `length` bytes of the data block. Every PLC can send at least 222 bytes.
///
/// # Errors
/// As for [`fetch`].
pub fn fetch_bytes(address: &Address, length: usize) -> Result<Vec<u8>> {
    fetch_from(address, 0, length)
}

fn fetch_from(address: &Address, offset: usize, length: usize) -> Result<Vec<u8>> {
    let stream = connect(address)?;
    let mut stream = Patient { stream, until: Instant::now() + PATIENCE };
    read(&mut stream, address, offset, length)
}

fn connect(address: &Address) -> Result<TcpStream> {
    let Address { host, port, .. } = address;
    let places = (host.as_str(), *port).to_socket_addrs();
    let place = places.ok().and_then(|mut places| places.next());
    let place =
        place.with_context(|| format!("the host name {host} is unknown: check it, or use the PLC's IP address"))?;
    let stream = TcpStream::connect_timeout(&place, PATIENCE).map_err(|error| match error.kind() {
        ErrorKind::ConnectionRefused => {
            anyhow!("{host} refuses connections to port {port}: it is not an S7 PLC, or a firewall blocks the port")
        }
        ErrorKind::TimedOut => anyhow!(
            "{host} did not answer within {} s: check the address, the cable, and that the firewalls allow port {port}",
            PATIENCE.as_secs()
        ),
        _ => anyhow!("{host} cannot be reached ({error}): check the address and the network"),
    })?;
    stream.set_write_timeout(Some(PATIENCE))?;
    stream.set_nodelay(true)?;
    Ok(stream)
}

/// A connection with a deadline for all reads together, even if each returns only a few bytes.
struct Patient {
    stream: TcpStream,
    until: Instant,
}

impl Read for Patient {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(Some(left(self.until, Instant::now())?))?;
        self.stream.read(bytes)
    }
}

/// The time left for a read that begins now.
fn left(until: Instant, now: Instant) -> io::Result<Duration> {
    let left = until.saturating_duration_since(now);
    if left.is_zero() { Err(ErrorKind::TimedOut.into()) } else { Ok(left) }
}

impl Write for Patient {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

/// Connects to the CPU and reads `length` bytes of the data block, from byte `start`.
fn read(stream: &mut (impl Read + Write), address: &Address, start: usize, length: usize) -> Result<Vec<u8>> {
    let answer = exchange(stream, &connection_request(address)).context(wrong_place(address))?;
    // The answer must be a connection confirm.
    ensure!(answer.first().is_some_and(|code| code & 0xF0 == 0xD0), "{}", wrong_place(address));

    let answer = exchange(stream, &SETUP)
        .context("the PLC may have no free connection; close another programming device or panel")?;
    let (parameters, _) = content(&answer, SETUP_FUNCTION)?;
    let granted = parameters.get(6..8).map_or(0, |granted| usize::from(u16::from_be_bytes([granted[0], granted[1]])));
    ensure!(
        length + OVERHEAD <= granted,
        "the block needs {length} bytes, but the PLC sends at most {} in one answer: two answers could hold values from \
         different moments",
        granted.saturating_sub(OVERHEAD)
    );

    let request = read_request(address.number, start, length)?;
    let answer = exchange(stream, &request)?;
    let (_, data) = content(&answer, READ_FUNCTION)?;
    let (&code, header) = data.split_first().context(NO_S7)?;
    ensure!(code == 0xFF, "{}", refusal(code, address.number, start + length));
    ensure!(header.len() >= 3, NO_S7);
    let bytes = &header[3..];
    ensure!(
        bytes.len() >= length,
        "the PLC sent {} bytes instead of {length}: DB{} is too short",
        bytes.len(),
        address.number
    );
    Ok(bytes[..length].to_vec())
}

const NO_S7: &str = "the answer is not from an S7 PLC: check the address and the port";

fn wrong_place(address: &Address) -> String {
    format!(
        "no CPU in rack {}, slot {}, or it accepts no connections: an S7-300 is in rack 0, slot 2, an S7-1200 or \
         S7-1500 in rack 0, slot 1; for an S7-400, see the hardware configuration",
        address.rack, address.slot
    )
}

/// Why the PLC refused to read the bytes, according to its return code; `end` is the offset after the last of them.
fn refusal(code: u8, number: u16, end: usize) -> String {
    match code {
        0x03 => format!(
            "the PLC denies access to DB{number}: lower the protection level of the CPU, or allow full access without a password"
        ),
        0x05 => format!(
            "DB{number} is shorter than {end} bytes, so it is not an instance of this block, or it is an optimized data block \
             of an S7-1200 or S7-1500: switch off \"Optimized block access\" in its properties and load it"
        ),
        0x06 | 0x07 => format!("the PLC cannot read bytes of DB{number} (code {code:#04x})"),
        0x0A => format!(
            "no DB{number} in the PLC, or it is an optimized data block of an S7-1200 or S7-1500: check the number, \
             and switch off \"Optimized block access\" in its properties"
        ),
        0x01 => "the PLC reports a hardware fault".into(),
        _ => format!("the PLC refuses to read DB{number} (code {code:#04x})"),
    }
}

/// Why a whole request was refused.
fn refusal_of_request(class: u8, code: u8) -> String {
    match (class, code) {
        (0x81, 0x04) => "the PLC does not offer this service: in an S7-1200 or S7-1500, tick \"Permit access with PUT/GET \
                         communication from remote partner\" under Protection & Security in the CPU's properties, and load it"
            .into(),
        (0xD2, 0x41) | (0xD6, _) => {
            "the PLC denies access by its protection level: allow reading without a password".to_string()
        }
        (0x85, _) => "the PLC rejected the request as too long".into(),
        (0x83, _) => "the PLC has no resources left for the request: try again later".into(),
        _ => format!("the PLC refuses the request (error class {class:#04x}, code {code:#04x})"),
    }
}

/// A TPDU that requests a connection: type PG, the rack and the slot in the called TSAP, TPDUs of up to 1024 bytes.
fn connection_request(address: &Address) -> Vec<u8> {
    let place = address.rack * 32 + address.slot;
    vec![0xE0, 0, 0, 0, 1, 0, 0xC0, 1, 0x0A, 0xC1, 2, 1, 0, 0xC2, 2, 1, place]
}

const SETUP_FUNCTION: u8 = 0xF0;
const READ_FUNCTION: u8 = 0x04;

/// The header, without the length byte, of a data TPDU that is the last of its message.
const DATA: [u8; 2] = [0xF0, 0x80];

/// The request that negotiates the PDU length, with one job at a time.
const SETUP: [u8; 20] = {
    let longest = LONGEST_PDU.to_be_bytes();
    [DATA[0], DATA[1], 0x32, 1, 0, 0, 0, 1, 0, 8, 0, 0, SETUP_FUNCTION, 0, 0, 1, 0, 1, longest[0], longest[1]]
};

/// The request for bytes of a data block. No function of the PLC other than this one and the setup is ever called.
fn read_request(number: u16, start: usize, length: usize) -> Result<Vec<u8>> {
    let bit = u32::try_from(start * 8).ok().filter(|bit| *bit < 1 << 24);
    let bit =
        bit.with_context(|| format!("the offset is {start}: a data block has fewer than 2097152 bytes"))?.to_be_bytes();
    let (length, number) = ((length as u16).to_be_bytes(), number.to_be_bytes());
    let mut request = DATA.to_vec();
    // A job with 14 bytes of parameters and no data.
    request.extend([0x32, 1, 0, 0, 0, 2, 0, 14, 0, 0]);
    // One item: bytes (2) of a data block (0x84).
    request.extend([READ_FUNCTION, 1, 0x12, 10, 0x10, 2, length[0], length[1], number[0], number[1], 0x84]);
    request.extend(&bit[1..]);
    Ok(request)
}

/// The parameters and data of an answer to a function.
fn content(answer: &[u8], function: u8) -> Result<(&[u8], &[u8])> {
    ensure!(answer.len() >= 2 && answer[0] == DATA[0], NO_S7);
    let pdu = &answer[2..];
    // The protocol identifier, and an acknowledgement with or without data.
    ensure!(pdu.len() >= 12 && pdu[0] == 0x32 && matches!(pdu[1], 2 | 3), NO_S7);
    let (class, code) = (pdu[10], pdu[11]);
    ensure!((class, code) == (0, 0), "{}", refusal_of_request(class, code));
    let size = |place: usize| usize::from(u16::from_be_bytes([pdu[place], pdu[place + 1]]));
    let (parameters, data) = (size(6), size(8));
    let content = pdu.get(12..12 + parameters + data).context(NO_S7)?;
    let (parameters, data) = content.split_at(parameters);
    ensure!(parameters.first() == Some(&function), NO_S7);
    Ok((parameters, data))
}

/// Sends a TPDU, given without its length byte, and returns the answer in the same form.
fn exchange(stream: &mut (impl Read + Write), tpdu: &[u8]) -> Result<Vec<u8>> {
    // The header's length does not count itself, nor the content of a data TPDU.
    let header = if tpdu.starts_with(&DATA) { DATA.len() } else { tpdu.len() };
    let mut message = vec![3, 0];
    message.extend((tpdu.len() as u16 + 5).to_be_bytes());
    message.push(header as u8);
    message.extend(tpdu);
    stream.write_all(&message).map_err(|error| failed(&error))?;

    let mut start = [0; 4];
    stream.read_exact(&mut start).map_err(|error| failed(&error))?;
    let length = usize::from(u16::from_be_bytes([start[2], start[3]]));
    ensure!(start[0] == 3 && length > 5, NO_S7);
    let mut answer = vec![0; length - 4];
    stream.read_exact(&mut answer).map_err(|error| failed(&error))?;
    answer.remove(0);
    Ok(answer)
}

fn failed(error: &std::io::Error) -> Error {
    match error.kind() {
        ErrorKind::WouldBlock | ErrorKind::TimedOut => {
            anyhow!("the PLC did not answer within {} s", PATIENCE.as_secs())
        }
        ErrorKind::UnexpectedEof
        | ErrorKind::ConnectionReset
        | ErrorKind::BrokenPipe
        | ErrorKind::ConnectionAborted => {
            anyhow!("the PLC closed the connection")
        }
        _ => anyhow!("{error}"),
    }
}

#[cfg(test)]
mod tests;
