//! The URIs of buffers and images.

use crate::load::LoadError;
use crate::load::error::printable;

/// Where a URI leads.
#[derive(Debug, PartialEq)]
pub(super) enum Target {
    /// The URI carries its data.
    Data(Vec<u8>),
    /// A path relative to the scene file.
    File(String),
}

impl Target {
    /// `owner` names the URI in errors.
    pub(super) fn of(uri: &str, owner: &str) -> Result<Self, LoadError> {
        let bad = |value: &str, expected| {
            LoadError::not_understood(format!("the URI of {owner}"), value.as_bytes(), expected)
        };
        let scheme = uri
            .split_once(':')
            .filter(|(scheme, _)| !scheme.contains(['/', '\\', '%', '?', '#']));
        if let Some((scheme, rest)) = scheme {
            if !scheme.eq_ignore_ascii_case("data") {
                let scheme: String = printable(scheme).chars().take(20).collect();
                return Err(LoadError::Unsupported(format!(
                    "the URI scheme {scheme} of {owner}"
                )));
            }
            let (kind, data) = rest
                .split_once(',')
                .ok_or_else(|| bad(uri, "a comma before the data"))?;
            let is_base64 = kind.rsplit(';').next() == Some("base64");
            let bytes = if is_base64 {
                base64(data).ok_or_else(|| bad(data, "base64 text"))?
            } else {
                percent(data).ok_or_else(|| bad(data, "two hexadecimal digits after each %"))?
            };
            return Ok(Self::Data(bytes));
        }
        let path = percent(uri).ok_or_else(|| bad(uri, "two hexadecimal digits after each %"))?;
        let path = String::from_utf8(path).map_err(|_| bad(uri, "UTF-8"))?;
        if path.is_empty() || path.starts_with(['/', '\\']) || path.contains('\0') {
            return Err(bad(&path, "a path relative to the scene file"));
        }
        Ok(Self::File(path))
    }
}

/// Decodes the standard alphabet; padding may be missing.
fn base64(text: &str) -> Option<Vec<u8>> {
    let digits = text.trim_end_matches('=').as_bytes();
    if digits.len() % 4 == 1 || text.len() - digits.len() > 2 {
        return None;
    }
    let mut bytes = Vec::with_capacity(digits.len() / 4 * 3 + 3);
    for group in digits.chunks(4) {
        let mut bits = 0;
        for digit in group {
            let value = match digit {
                b'A'..=b'Z' => digit - b'A',
                b'a'..=b'z' => digit - b'a' + 26,
                b'0'..=b'9' => digit - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => return None,
            };
            bits = bits << 6 | u32::from(value);
        }
        bits <<= 6 * (4 - group.len());
        bytes.extend_from_slice(&bits.to_be_bytes()[1..group.len()]);
    }
    Some(bytes)
}

fn percent(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&byte, behind)) = rest.split_first() {
        rest = behind;
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let (digits, behind) = rest.split_first_chunk::<2>()?;
        let hex = |digit: u8| char::from(digit).to_digit(16);
        bytes.push((hex(digits[0])? * 16 + hex(digits[1])?) as u8);
        rest = behind;
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_comes_out_of_the_uri() {
        let data = |text: &str| Target::Data(text.as_bytes().to_vec());
        for (uri, target) in [
            (
                "data:application/octet-stream;base64,Zm9nZ3k=",
                data("foggy"),
            ),
            ("data:;base64,Zm9n", data("fog")),
            ("DATA:;base64,Zm9nZw", data("fogg")),
            ("data:;base64,", data("")),
            ("data:text/plain,a%20b%2c", data("a b,")),
            ("../a%20b/%C3%A4.bin", Target::File("../a b/ä.bin".into())),
            ("a+b.png", Target::File("a+b.png".into())),
        ] {
            assert_eq!(Target::of(uri, "buffer 0").unwrap(), target, "{uri}");
        }
        let bytes = base64("+/8A").unwrap();
        assert_eq!(bytes, [0xfb, 0xff, 0x00]);
    }

    #[test]
    fn other_uris_are_refused() {
        for (uri, cause) in [
            ("https://example.org/a.bin", "scheme https of buffer 0"),
            ("C:\\a.bin", "scheme C"),
            ("/etc/passwd", "relative"),
            ("%2Fetc/passwd", "relative"),
            ("", "relative"),
            ("a%00b", "relative"),
            ("a%0", "hexadecimal"),
            ("a%zz", "hexadecimal"),
            ("%ff.bin", "UTF-8"),
            ("data:;base64", "comma"),
            ("data:;base64,Zm9nZ", "base64"),
            ("data:;base64,Zm9n====", "base64"),
            ("data:;base64,Zm 9n", "base64"),
        ] {
            let error = Target::of(uri, "buffer 0").unwrap_err().to_string();
            assert!(error.contains(cause), "{uri}: {error}");
        }
    }
}
