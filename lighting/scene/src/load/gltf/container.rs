//! The outer shell of a file: GLB chunks or plain JSON, and whether the JSON
//! may be handed to a parser.

use gltf_json::Root;

use crate::load::LoadError;

/// The parser makes a struct of some hundred bytes out of a `{}`, so the
/// number of values in a document is limited, not only its length.
const MAX_VALUES: u64 = 1 << 22;

/// Extensions that are read.
const SUPPORTED: [&str; 2] = ["KHR_lights_punctual", "KHR_materials_emissive_strength"];

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
        if version != 2 {
            return Err(LoadError::Unsupported(format!("GLB version {version}")));
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
                    String::from_utf8_lossy(&kind),
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
            format!("the GLB chunk {}", String::from_utf8_lossy(kind)),
            length.into(),
            rest.len(),
        )),
    }
}

/// Parses the document; the indices in it are not checked yet.
pub(super) fn parse(json: &[u8]) -> Result<Root, LoadError> {
    let values = count_values(json);
    if values > MAX_VALUES {
        return Err(LoadError::bad_value(
            "the number of values in the glTF document",
            values,
            "at most 2^22",
        ));
    }
    let root: Root = gltf_json::deserialize::from_slice(json)
        .map_err(|error| LoadError::Json(error.to_string()))?;
    let version = root
        .asset
        .min_version
        .as_ref()
        .unwrap_or(&root.asset.version);
    if version.split('.').next() != Some("2")
        || (root.asset.min_version.is_some() && version != "2.0")
    {
        return Err(LoadError::Unsupported(format!(
            "glTF version {version:.20}"
        )));
    }
    if let Some(name) = root
        .extensions_required
        .iter()
        .find(|name| !is_supported(name))
    {
        return Err(LoadError::Unsupported(format!(
            "the extension {name:.80}, which the file requires,"
        )));
    }
    Ok(root)
}

pub(super) fn is_supported(extension: &str) -> bool {
    SUPPORTED.contains(&extension)
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
