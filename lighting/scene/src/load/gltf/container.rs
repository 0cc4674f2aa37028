//! The outer shell of a file: GLB chunks or plain JSON, and whether the JSON
//! may be handed to a parser.

use gltf_json::{Root, Value};

use crate::load::LoadError;

/// The parser makes a struct of some hundred bytes out of a `{}`, so the
/// number of values in a document is limited, not only its length.
const MAX_VALUES: u64 = 1 << 22;

/// The parts of a GLB file, or a glTF file as the first of them.
#[derive(Debug)]
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    pub(super) binary: Option<&'a [u8]>,
}

impl<'a> Container<'a> {
    pub(super) fn split(bytes: &'a [u8]) -> Result<Self, LoadError> {
        if !bytes.starts_with(b"glTF") {
            return Ok(Self {
                json: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes),
                binary: None,
            });
        }
        let Some((header, _)) = bytes.split_first_chunk::<12>() else {
            return Err(LoadError::truncated("the GLB header", 12, bytes.len()));
        };
        let word = |at: usize| {
            u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]])
        };
        let (version, length) = (word(4), word(8));
        match version {
            2 => {}
            1 => return Err(LoadError::Unsupported("glTF 1.0 (GLB version 1)".into())),
            _ => return Err(LoadError::Unsupported(format!("GLB version {version}"))),
        }
        if u64::from(length) > bytes.len() as u64 {
            return Err(LoadError::truncated(
                "the GLB file",
                length.into(),
                bytes.len(),
            ));
        }
        let Some(mut rest) = bytes.get(12..length as usize) else {
            return Err(LoadError::bad_value(
                "the length in the GLB header",
                length,
                "at least 12",
            ));
        };
        let (mut json, mut binary) = (None, None);
        // Chunks of other kinds are allowed behind the first and ignored.
        while let Some((kind, data, behind)) = chunk(rest)? {
            match &kind {
                b"JSON" if json.is_none() => json = Some(data),
                b"BIN\0" if binary.is_none() => binary = Some(data),
                _ => {}
            }
            if json.is_none() {
                return Err(LoadError::bad_value(
                    "the first GLB chunk",
                    "of another kind",
                    "JSON",
                ));
            }
            rest = behind;
        }
        match json {
            Some(json) => Ok(Self { json, binary }),
            None => Err(LoadError::truncated("the first GLB chunk", 8, 0)),
        }
    }
}

type Chunk<'a> = ([u8; 4], &'a [u8], &'a [u8]);

/// The kind and data of the first chunk, and what is behind it.
fn chunk(bytes: &[u8]) -> Result<Option<Chunk<'_>>, LoadError> {
    if bytes.is_empty() {
        return Ok(None);
    }
    let Some((length, rest)) = bytes.split_first_chunk::<4>() else {
        return Err(LoadError::truncated("a GLB chunk header", 8, bytes.len()));
    };
    let Some((kind, rest)) = rest.split_first_chunk::<4>() else {
        return Err(LoadError::truncated("a GLB chunk header", 8, bytes.len()));
    };
    let length = u32::from_le_bytes(*length);
    match rest.split_at_checked(length as usize) {
        Some((data, behind)) => Ok(Some((*kind, data, behind))),
        None => Err(LoadError::truncated(
            match kind {
                b"JSON" => "the GLB chunk JSON",
                b"BIN\0" => "the GLB chunk BIN",
                _ => "a GLB chunk of another kind",
            },
            length.into(),
            rest.len(),
        )),
    }
}

/// A document whose indices are not checked yet.
#[derive(Debug)]
pub(super) struct Document {
    pub(super) root: Root,
    /// The same, for what the types of the library do not know.
    pub(super) value: Value,
    /// Animations themselves are dropped.
    pub(super) has_animations: bool,
}

/// Parses the document.
pub(super) fn parse(json: &[u8]) -> Result<Document, LoadError> {
    let values = count_values(json);
    if values > MAX_VALUES {
        return Err(LoadError::bad_value(
            "the number of values in the glTF document",
            values,
            "at most 2^22",
        ));
    }
    let mut value: Value = gltf_json::deserialize::from_slice(json)
        .map_err(|error| LoadError::Json(without_quotes(&error.to_string())))?;
    check_version(&value)?;
    let has_animations = normalise(&mut value);
    let root = gltf_json::deserialize::from_value(value.clone()).map_err(json_error)?;
    Ok(Document {
        root,
        value,
        has_animations,
    })
}

fn json_error(error: impl std::fmt::Display) -> LoadError {
    LoadError::Json(without_quotes(&error.to_string()))
}

/// Before the rest is looked at: documents of version 1 have other types.
fn check_version(document: &Value) -> Result<(), LoadError> {
    let asset = document.get("asset");
    let text = |name: &str| asset.and_then(|asset| asset.get(name));
    let is_old = |version: &Value| match version.as_str() {
        Some(version) => version.starts_with("1."),
        None => version
            .as_f64()
            .is_some_and(|version| (1.0..2.0).contains(&version)),
    };
    // An asset was optional in version 1, and lists were objects.
    let looks_old = asset.is_none() && document.get("nodes").is_some_and(Value::is_object);
    if text("version").is_some_and(is_old) || looks_old {
        return Err(LoadError::Unsupported("glTF 1.0 (version 1.0)".into()));
    }
    let version = |name: &str| text(name).and_then(Value::as_str);
    let unsupported = |version: &str| {
        let version: String = version
            .chars()
            .take(20)
            .map(|c| {
                if c.is_ascii_digit() || c == '.' {
                    c
                } else {
                    '?'
                }
            })
            .collect();
        Err(LoadError::Unsupported(format!("glTF version {version}")))
    };
    match (version("minVersion"), version("version")) {
        (Some("2.0"), _) => Ok(()),
        (Some(least), _) => unsupported(least),
        (None, Some(version)) if version.split('.').next() == Some("2") => Ok(()),
        (None, Some(version)) => unsupported(version),
        // The library says what is missing.
        (None, None) => Ok(()),
    }
}

/// Fills in what the specification lets out and the library insists on, and
/// drops animations. Returns whether there were any.
fn normalise(document: &mut Value) -> bool {
    fn list<'a>(document: &'a mut Value, name: &str) -> impl Iterator<Item = &'a mut Value> {
        let list = document.get_mut(name).and_then(Value::as_array_mut);
        list.into_iter().flatten()
    }
    let animations = document.get_mut("animations").map(Value::take);
    for scene in list(document, "scenes").filter_map(Value::as_object_mut) {
        scene
            .entry("nodes")
            .or_insert_with(|| Value::Array(Vec::new()));
    }
    for texture in list(document, "textures").filter_map(Value::as_object_mut) {
        if texture.contains_key("source") {
            continue;
        }
        // The image in a format that is not read, or none: a note says so.
        let of_extension = ["EXT_texture_webp", "KHR_texture_basisu", "MSFT_texture_dds"]
            .into_iter()
            .find_map(|name| texture.get("extensions")?.get(name)?.get("source").cloned());
        texture.insert("source".into(), of_extension.unwrap_or(NO_IMAGE.into()));
    }
    if let Some(document) = document.as_object_mut() {
        // Nothing is an empty list to the library, null is not.
        document.remove("animations");
    }
    animations.is_some_and(|list| list.as_array().is_some_and(|list| !list.is_empty()))
}

/// The image of a texture that has none.
const NO_IMAGE: u32 = u32::MAX;

/// What the parser says, without the parts of the file that it repeats.
fn without_quotes(message: &str) -> String {
    match (message.find(['"', '`']), message.rfind(['"', '`'])) {
        // Names of fields are the library's, in backticks.
        (Some(first), Some(last)) if message.contains('"') && first < last => {
            format!("{}a text{}", &message[..first], &message[last + 1..])
        }
        _ => message.to_owned(),
    }
}

/// An upper bound of the number of values in JSON text.
fn count_values(json: &[u8]) -> u64 {
    let (mut count, mut in_string, mut escaped) = (1, false, false);
    for byte in json {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if in_string => escaped = true,
            b'"' => in_string = !in_string,
            b'{' | b'[' | b',' if !in_string => count += 1,
            _ => {}
        }
    }
    count
}
