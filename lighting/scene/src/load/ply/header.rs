//! The header of a PLY file.

use crate::load::LoadError;

/// How the numbers of the body are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A number type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// What was expected if it is none.
    fn from_name(name: &str) -> Result<Self, &'static str> {
        Ok(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => {
                return Err(
                    "one of the types char, uchar, short, ushort, int, uint, float, double",
                );
            }
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// A column of an element.
#[derive(Debug, Clone)]
pub(super) struct Property {
    pub(super) name: String,
    /// The type of the length if this is a list.
    pub(super) list: Option<Scalar>,
    /// The type of the value, or of each item.
    pub(super) item: Scalar,
}

/// A table of the body.
#[derive(Debug, Clone)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// The fewest bytes that a row can take. In ASCII that is a digit and a
    /// separator per value; the last separator of a file may be missing.
    pub(super) fn least_row_bytes(&self, encoding: Encoding) -> u64 {
        let bytes = |p: &Property| match encoding {
            Encoding::Ascii => 2,
            _ => p.list.unwrap_or(p.item).size() as u64,
        };
        self.properties.iter().map(bytes).sum()
    }
}

/// The header and where the body begins.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    pub(super) length: usize,
}

impl Header {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, LoadError> {
        let mut lines = Lines::new(bytes);
        let magic = lines.next()?;
        if magic != "ply" {
            return Err(LoadError::not_understood(
                "the first line",
                magic.as_bytes(),
                "\"ply\"",
            ));
        }
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        loop {
            let line = lines.next()?;
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let number = lines.number;
            let bad = |expected| {
                LoadError::not_understood(
                    format!("line {number} of the PLY header"),
                    line.as_bytes(),
                    expected,
                )
            };
            match words[..] {
                [] | ["comment" | "obj_info", ..] => {}
                ["end_header"] => break,
                ["format", format, version] => {
                    if version != "1.0" {
                        return Err(LoadError::Unsupported(format!(
                            "the PLY version {}of line {number}",
                            number_of(version)
                        )));
                    }
                    encoding = Some(match format {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::LittleEndian,
                        "binary_big_endian" => Encoding::BigEndian,
                        _ => {
                            return Err(bad(
                                "the format ascii, binary_little_endian or binary_big_endian",
                            ));
                        }
                    });
                }
                ["element", name, count] => {
                    if elements.iter().any(|e| e.name == name) {
                        return Err(bad("an element with each name once"));
                    }
                    elements.push(Element {
                        name: name.to_owned(),
                        count: count
                            .parse()
                            .map_err(|_| bad("a whole number of elements below 2^64"))?,
                        properties: Vec::new(),
                    });
                }
                ["property", ref rest @ ..] => {
                    let property = Property::parse(rest).map_err(bad)?;
                    let element = elements
                        .last_mut()
                        .ok_or_else(|| bad("an element line before"))?;
                    element.properties.push(property);
                }
                _ => {
                    return Err(bad(
                        "a format, element, property, comment or end_header line",
                    ));
                }
            }
        }
        Ok(Self {
            encoding: encoding.ok_or_else(|| {
                LoadError::bad_value("the PLY header", "without a format", "a format line")
            })?,
            elements,
            length: lines.position,
        })
    }
}

impl Property {
    /// What was expected if it is none.
    fn parse(words: &[&str]) -> Result<Self, &'static str> {
        match *words {
            ["list", length, item, name] => {
                let length = Scalar::from_name(length)?;
                if !length.is_integer() {
                    return Err("a list whose length is an integer");
                }
                Ok(Self {
                    name: name.to_owned(),
                    list: Some(length),
                    item: Scalar::from_name(item)?,
                })
            }
            [item, name] => Ok(Self {
                name: name.to_owned(),
                list: None,
                item: Scalar::from_name(item)?,
            }),
            _ => Err("property TYPE NAME or property list TYPE TYPE NAME"),
        }
    }
}

/// The text of a version if it is one.
fn number_of(version: &str) -> String {
    let is_version = |c: char| c.is_ascii_digit() || c == '.';
    if version.len() <= 8 && version.chars().all(is_version) {
        format!("{version} ")
    } else {
        String::new()
    }
}

/// Lines that end in `\n`, `\r\n` or `\r`, whichever ends the first one.
struct Lines<'a> {
    bytes: &'a [u8],
    position: usize,
    /// Of the line that was read last, from 1.
    number: usize,
    end: u8,
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let end = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let only_returns = end.is_some_and(|at| bytes[at..].starts_with(b"\r"))
            && end.is_some_and(|at| bytes.get(at + 1) != Some(&b'\n'));
        Self {
            bytes,
            position: 0,
            number: 0,
            end: if only_returns { b'\r' } else { b'\n' },
        }
    }

    fn next(&mut self) -> Result<&'a str, LoadError> {
        let rest = &self.bytes[self.position..];
        let Some(length) = rest.iter().position(|&b| b == self.end) else {
            return Err(LoadError::truncated(
                "the PLY header (it has no end_header line)",
                self.bytes.len() as u64 + 1,
                self.bytes.len(),
            ));
        };
        self.position += length + 1;
        self.number += 1;
        let line = rest[..length]
            .strip_suffix(b"\r")
            .unwrap_or(&rest[..length]);
        std::str::from_utf8(line).or_else(|_| {
            // Old comments may be in any encoding; nothing else may.
            if line.starts_with(b"comment") || line.starts_with(b"obj_info") {
                Ok("comment")
            } else {
                Err(LoadError::not_understood(
                    format!("line {} of the PLY header", self.number),
                    line,
                    "text",
                ))
            }
        })
    }
}
