//! Messages between this program and the processes it starts, over their standard input and output.
//!
//! A message consists of the length of its contents, as 4 bytes in little-endian order, and the contents.

use std::io::{self, Read, Write};
use std::process;
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread;
use std::time::Duration;

/// The maximum length of a message's contents, in bytes.
const LONGEST: u32 = 1 << 28;

/// The time that a process may take to free its instances and exit after its input has ended.
pub const FAREWELL: Duration = Duration::from_secs(2);

/// Sends a message.
///
/// # Errors
/// The message is too long, or the other side has ended.
pub fn send(to: &mut impl Write, message: &[u8]) -> io::Result<()> {
    let length = u32::try_from(message.len()).ok().filter(|length| *length <= LONGEST);
    let length = length
        .ok_or_else(|| io::Error::other(format!("a message has {} bytes: the limit is {LONGEST}", message.len())))?;
    // In one write, because the other side waits for the whole message.
    let mut bytes = length.to_le_bytes().to_vec();
    bytes.extend_from_slice(message);
    to.write_all(&bytes)?;
    to.flush()
}

/// Receives the next message; `None` at the end of the stream.
///
/// # Errors
/// The contents are truncated or too long, or cannot be read.
pub fn receive(from: &mut impl Read) -> io::Result<Option<Vec<u8>>> {
    let mut length = [0; 4];
    match from.read_exact(&mut length) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        read => read?,
    }
    let length = u32::from_le_bytes(length);
    if length > LONGEST {
        return Err(io::Error::other(format!("a message has {length} bytes: the limit is {LONGEST}")));
    }
    let mut message = vec![0; length as usize];
    from.read_exact(&mut message)?;
    Ok(Some(message))
}

/// The messages on standard input of this process, read by a thread, and a sender to keep until everything has been
/// freed. Once the input has ended, the thread ends the process when that sender is dropped, or after [`FAREWELL`] if
/// an FMU does not return.
pub fn input() -> (Receiver<Vec<u8>>, Sender<()>) {
    let (sender, messages) = mpsc::channel();
    let (at_work, is_over) = mpsc::channel::<()>();
    thread::spawn(move || {
        let mut input = io::stdin().lock();
        while let Ok(Some(message)) = receive(&mut input) {
            if sender.send(message).is_err() {
                break;
            }
        }
        drop(sender);
        // The other side is gone. If the FMU does not return, the process exits anyway.
        let _ = is_over.recv_timeout(FAREWELL);
        process::exit(1);
    });
    (messages, at_work)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_received_as_they_were_sent() {
        let mut stream = Vec::new();
        send(&mut stream, &[1, 2, 3]).unwrap();
        send(&mut stream, &[]).unwrap();
        let mut stream = stream.as_slice();
        assert_eq!(receive(&mut stream).unwrap(), Some(vec![1, 2, 3]));
        assert_eq!(receive(&mut stream).unwrap(), Some(Vec::new()));
        assert_eq!(receive(&mut stream).unwrap(), None);
    }

    #[test]
    fn a_message_that_is_cut_off_or_too_long_is_refused() {
        receive(&mut [9, 0, 0, 0, 1].as_slice()).unwrap_err();
        let error = receive(&mut u32::MAX.to_le_bytes().as_slice()).unwrap_err();
        assert_eq!(error.to_string(), "a message has 4294967295 bytes: the limit is 268435456");
    }
}
