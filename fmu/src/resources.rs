//! The FMU's `resources` folder: from the URI passed by a host to the folders it may refer to.
//!
//! Hosts write the URI of a folder in many ways: `file:///x`, `file:/x`, `file://localhost/x`, `file:////x`, with or
//! without percent escapes, with backslashes, with a trailing slash, or as a plain path. If a string may refer to
//! several folders, the first that contains the file is used; the identifier derived from its content shows whether it
//! is the right one.

use crate::preset::Argument;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The maximum length of a URI, in bytes.
const LONGEST: usize = 1 << 15;

/// The maximum length of a path in a message, in characters.
const SHOWN: usize = 300;

/// The path syntax of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Style {
    Unix,
    Windows,
}

/// Reads a file of at most `limit` bytes from the folder with this URI; also returns its path.
///
/// # Errors
/// The URI is not that of a folder, or the file is missing, unreadable or too large. The message is worded to follow
/// "but".
pub fn read(location: Argument, name: &str, limit: u64) -> Result<(String, Vec<u8>), String> {
    let Argument { name: argument, value } = location;
    let location = value.ok_or_else(|| format!("{argument} is NULL"))?.to_bytes();
    if location.len() > LONGEST {
        return Err(format!("{argument} has {} bytes; at most {LONGEST} are accepted", location.len()));
    }
    let style = if cfg!(windows) { Style::Windows } else { Style::Unix };
    let files: Vec<PathBuf> =
        folders(location, style).into_iter().filter_map(path).map(|folder| folder.join(name)).collect();
    let Some(first) = files.first() else {
        let location = String::from_utf8_lossy(location);
        return Err(format!("{argument} = {:?} is not the URI of a folder (file:///...)", cut(&location)));
    };
    // Opening anything other than a regular file might block forever.
    let is_file = |path: &&PathBuf| fs::metadata(path).is_ok_and(|metadata| metadata.is_file());
    let Some(found) = files.iter().find(is_file) else {
        return Err(format!("there is no file {}", shown(first)));
    };
    let mut bytes = Vec::new();
    match File::open(found).and_then(|file| file.take(limit + 1).read_to_end(&mut bytes)) {
        Err(error) => Err(format!("{} cannot be read: {error}", shown(found))),
        Ok(length) if length as u64 > limit => Err(format!("{} has more than {limit} bytes", shown(found))),
        Ok(_) => Ok((shown(found), bytes)),
    }
}

fn shown(path: &Path) -> String {
    cut(&path.display().to_string())
}

/// The text in at most [`SHOWN`] characters. The end of a path is more informative than its beginning.
fn cut(text: &str) -> String {
    match text.char_indices().rev().nth(SHOWN) {
        Some((start, character)) => format!("…{}", &text[start + character.len_utf8()..]),
        None => text.to_string(),
    }
}

#[cfg(unix)]
fn path(bytes: Vec<u8>) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStringExt;
    Some(std::ffi::OsString::from_vec(bytes).into())
}

#[cfg(not(unix))]
fn path(bytes: Vec<u8>) -> Option<PathBuf> {
    String::from_utf8(bytes).ok().map(PathBuf::from)
}

/// The folders that the location may refer to, the most likely first; empty if it is not the URI of a folder.
fn folders(location: &[u8], style: Style) -> Vec<Vec<u8>> {
    let mut folders: Vec<Vec<u8>> = Vec::new();
    let mut add = |folder: Vec<u8>| {
        if !folder.is_empty() && !folders.contains(&folder) {
            folders.push(folder);
        }
    };
    let Some(rest) = without_scheme(location) else {
        if !has_scheme(location) {
            add(location.to_vec());
        }
        return folders;
    };
    // A backslash separates folders on Windows and is an ordinary character elsewhere, but some hosts use it there too.
    let slashed: Vec<u8> = rest.iter().map(|byte| if *byte == b'\\' { b'/' } else { *byte }).collect();
    let written = if style == Style::Windows { vec![slashed] } else { vec![rest.to_vec(), slashed] };
    for text in &written {
        let decoded = decoded(text);
        // Decoded, as the standard requires; unchanged, for hosts that do not encode; for hosts that encode twice.
        for text in [&decoded, text, &self::decoded(&decoded)] {
            add(local_path(text, style));
        }
    }
    folders
}

/// The part after `file:`, ignoring case.
fn without_scheme(location: &[u8]) -> Option<&[u8]> {
    let (scheme, rest) = location.split_at_checked(5)?;
    scheme.eq_ignore_ascii_case(b"file:").then_some(rest)
}

/// Whether the location begins with a URI scheme. A single letter before the colon is a drive.
fn has_scheme(location: &[u8]) -> bool {
    let length = location.iter().take_while(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(byte)).count();
    length > 1 && location.get(length) == Some(&b':')
}

/// The path in a URI whose scheme has been removed: `//host/path` or `/path`.
fn local_path(text: &[u8], style: Style) -> Vec<u8> {
    let path = match text.strip_prefix(b"//") {
        None => text.to_vec(),
        Some(rest) => {
            let end = rest.iter().position(|byte| *byte == b'/').unwrap_or(rest.len());
            let (host, path) = rest.split_at(end);
            match style {
                _ if host.is_empty() || host.eq_ignore_ascii_case(b"localhost") => path.to_vec(),
                Style::Windows if is_drive(host) => rest.to_vec(),
                // A network share, `//server/share`.
                Style::Windows => text.to_vec(),
                // One slash too few: the supposed host is part of the path.
                Style::Unix => [b"/", rest].concat(),
            }
        }
    };
    let inner = path.iter().position(|byte| *byte != b'/').unwrap_or(path.len());
    if style == Style::Windows && is_drive(&path[inner..]) { path[inner..].to_vec() } else { path }
}

/// Whether the text begins with `C:`.
fn is_drive(text: &[u8]) -> bool {
    matches!(text, [letter, b':', ..] if letter.is_ascii_alphabetic())
}

/// The text with each percent escape, such as `%20`, replaced by its byte. A percent sign that does not begin an escape
/// is kept.
fn decoded(text: &[u8]) -> Vec<u8> {
    let digit = |place: usize| text.get(place).and_then(|byte| char::from(*byte).to_digit(16));
    let mut bytes = Vec::with_capacity(text.len());
    let mut place = 0;
    while let Some(byte) = text.get(place) {
        match (byte, digit(place + 1), digit(place + 2)) {
            (b'%', Some(high), Some(low)) => {
                bytes.push((high * 16 + low) as u8);
                place += 3;
            }
            _ => {
                bytes.push(*byte);
                place += 1;
            }
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::CString;

    /// The folder that is looked into first.
    fn first(location: &str, style: Style) -> String {
        String::from_utf8(folders(location.as_bytes(), style).remove(0)).unwrap()
    }

    #[test]
    fn a_folder_is_found_however_a_host_writes_its_uri() {
        for (location, folder) in [
            ("file:///tmp/x/resources", "/tmp/x/resources"),
            ("file:/tmp/x/resources", "/tmp/x/resources"),
            ("FILE:///tmp/x/resources/", "/tmp/x/resources/"),
            ("file://localhost/tmp/x", "/tmp/x"),
            ("file:////tmp/x", "//tmp/x"),
            ("file://tmp/x", "/tmp/x"),
            ("file:///tmp/a%20b/%C3%A4%23%3f", "/tmp/a b/ä#?"),
            ("file:///tmp/a b/ä", "/tmp/a b/ä"),
            ("file:///tmp/100%/x%zz%4", "/tmp/100%/x%zz%4"),
            ("/tmp/a b/%20", "/tmp/a b/%20"),
            ("resources", "resources"),
        ] {
            assert_eq!(first(location, Style::Unix), folder, "{location}");
        }
    }

    #[test]
    fn a_folder_of_windows_is_found_however_a_host_writes_its_uri() {
        for (location, folder) in [
            ("file:///C:/x/resources", "C:/x/resources"),
            ("file:/C:/x/resources/", "C:/x/resources/"),
            ("file://C:/x", "C:/x"),
            ("file:C:/x", "C:/x"),
            ("file://localhost/c:/x", "c:/x"),
            ("file:////C:/x", "C:/x"),
            ("file:///C%3A/a%20b/%C3%A4", "C:/a b/ä"),
            ("file:\\\\\\C:\\x\\resources", "C:/x/resources"),
            ("file:///C:\\x\\resources", "C:/x/resources"),
            ("file://server/share/x", "//server/share/x"),
            ("C:\\a b\\%20", "C:\\a b\\%20"),
            ("\\\\server\\share\\x", "\\\\server\\share\\x"),
        ] {
            assert_eq!(first(location, Style::Windows), folder, "{location}");
        }
    }

    #[test]
    fn what_may_mean_two_folders_is_looked_for_in_both() {
        let all = |location: &str| -> Vec<String> {
            folders(location.as_bytes(), Style::Unix).into_iter().map(|each| String::from_utf8(each).unwrap()).collect()
        };
        assert_eq!(all("file:///a%2520b"), ["/a%20b", "/a%2520b", "/a b"]);
        assert_eq!(all("file:///a\\b"), ["/a\\b", "/a/b"]);
        assert_eq!(all("file:///a"), ["/a"]);
    }

    #[test]
    fn what_is_no_folder_of_this_machine_means_none() {
        for location in ["", "file:", "file://", "http://x/y", "urn:uuid:1", "jar:file:///x"] {
            assert_eq!(folders(location.as_bytes(), Style::Unix), Vec::<Vec<u8>>::new(), "{location}");
        }
    }

    #[test]
    fn escapes_that_are_not_utf_8_are_bytes() {
        assert_eq!(decoded(b"a%ff%C3%00"), b"a\xff\xc3\0");
    }

    /// What is said of a location.
    fn refusal(location: &[u8]) -> String {
        read(Argument { name: "location", value: Some(&CString::new(location).unwrap()) }, "start.txt", 10).unwrap_err()
    }

    #[test]
    fn a_refusal_says_what_is_missing_where() {
        assert_eq!(read(Argument { name: "location", value: None }, "start.txt", 10).unwrap_err(), "location is NULL");
        assert_eq!(refusal(b""), "location = \"\" is not the URI of a folder (file:///...)");
        assert_eq!(refusal(b"file:///no/such%20folder"), "there is no file /no/such folder/start.txt");
        assert_eq!(refusal(&vec![b'x'; 40_000]), "location has 40000 bytes; at most 32768 are accepted");
        let long = refusal(&[b"file:///".to_vec(), vec![b'x'; 30_000]].concat());
        assert!(long.ends_with("xxx/start.txt") && long.len() < 400, "{long}");
        for odd in [b"file:///%00".as_slice(), b"file:///\xff%ff", b"%", b"file:///dev/null/%"] {
            assert!(refusal(odd).starts_with("there is no file "), "{odd:?}");
        }
    }
}
