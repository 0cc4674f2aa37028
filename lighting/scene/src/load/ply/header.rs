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
    fn from_name(name: &str) -> Result<Self, LoadError> {
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
                return Err(LoadError::bad_value(
                    "a PLY property type",
                    name,
                    "char, uchar, short, ushort, int, uint, float or double",
                ));
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
        let mut lines = Lines { bytes, position: 0 };
        let magic = lines.next()?;
        if magic != "ply" {
            return Err(LoadError::bad_value("the first line", magic, "\"ply\""));
        }
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        loop {
            let line = lines.next()?;
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words[..] {
                [] | ["comment" | "obj_info", ..] => {}
                ["end_header"] => break,
                ["format", format, version] => {
                    if version != "1.0" {
                        return Err(LoadError::Unsupported(format!("PLY version {version}")));
                    }
                    encoding = Some(match format {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::LittleEndian,
                        "binary_big_endian" => Encoding::BigEndian,
                        _ => return Err(LoadError::Unsupported(format!("PLY format {format}"))),
                    });
                }
                ["element", name, count] => {
                    if elements.iter().any(|e| e.name == name) {
                        return Err(LoadError::bad_value(
                            "a PLY element",
                            name,
                            "each name once",
                        ));
                    }
                    elements.push(Element {
                        name: name.to_owned(),
                        count: count.parse().map_err(|_| {
                            LoadError::bad_value(
                                format!("the number of PLY elements \"{name}\""),
                                count,
                                "a whole number below 2^64",
                            )
                        })?,
                        properties: Vec::new(),
                    });
                }
                ["property", ref rest @ ..] => {
                    let property = Property::parse(rest, line)?;
                    let element = elements.last_mut().ok_or_else(|| {
                        LoadError::bad_value("a PLY header line", line, "an element line before")
                    })?;
                    element.properties.push(property);
                }
                _ => {
                    return Err(LoadError::bad_value(
                        "a PLY header line",
                        line,
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
    fn parse(words: &[&str], line: &str) -> Result<Self, LoadError> {
        match *words {
            ["list", length, item, name] => {
                let length = Scalar::from_name(length)?;
                if !length.is_integer() {
                    return Err(LoadError::bad_value(
                        "a PLY header line",
                        line,
                        "a list whose length is an integer",
                    ));
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
            _ => Err(LoadError::bad_value(
                "a PLY header line",
                line,
                "property TYPE NAME or property list TYPE TYPE NAME",
            )),
        }
    }
}

/// Lines that end in `\n` or `\r\n`.
struct Lines<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Result<&'a str, LoadError> {
        let rest = &self.bytes[self.position..];
        let Some(length) = rest.iter().position(|&b| b == b'\n') else {
            return Err(LoadError::truncated(
                "the PLY header (it has no end_header line)",
                self.bytes.len() as u64 + 1,
                self.bytes.len(),
            ));
        };
        self.position += length + 1;
        let line = rest[..length]
            .strip_suffix(b"\r")
            .unwrap_or(&rest[..length]);
        std::str::from_utf8(line).or_else(|_| {
            // Old comments may be in any encoding; nothing else may.
            if line.starts_with(b"comment") || line.starts_with(b"obj_info") {
                Ok("comment")
            } else {
                Err(LoadError::bad_value(
                    "a PLY header line",
                    String::from_utf8_lossy(line),
                    "text",
                ))
            }
        })
    }
}
