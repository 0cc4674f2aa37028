//! Buffers and views of them, decompressed.

use std::collections::BTreeMap;

use gltf_json::accessor::Accessor;
use gltf_json::{Index, Root, Value, buffer};

use super::draco::Decompressed;
use super::meshopt::{Filter, Layout, Mode};
use super::uri::Target;
use super::{entry, label};
use crate::load::limits::Budget;
use crate::load::{LoadError, OpenFile};

/// The buffers of a document, read when they are first needed.
pub(super) struct Buffers<'a> {
    pub(super) root: &'a Root,
    value: &'a Value,
    /// The document uses `KHR_mesh_quantization`.
    pub(super) quantised: bool,
    /// The binary chunk of a GLB file.
    binary: Option<&'a [u8]>,
    open: OpenFile<'a>,
    read: BTreeMap<usize, Vec<u8>>,
    /// Views that were compressed.
    decoded: BTreeMap<usize, Vec<u8>>,
    /// Accessors of a primitive that was compressed as a whole.
    decompressed: BTreeMap<usize, Decompressed>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(
        root: &'a Root,
        value: &'a Value,
        binary: Option<&'a [u8]>,
        open: OpenFile<'a>,
    ) -> Self {
        let mut extensions = root.extensions_used.iter().chain(&root.extensions_required);
        Self {
            root,
            value,
            quantised: extensions.any(|name| name == "KHR_mesh_quantization"),
            binary,
            open,
            read: BTreeMap::new(),
            decoded: BTreeMap::new(),
            decompressed: BTreeMap::new(),
        }
    }

    /// Gives an accessor elements that are in no view.
    pub(super) fn put(&mut self, accessor: Index<Accessor>, elements: Decompressed) {
        self.decompressed.insert(accessor.value(), elements);
    }

    /// Those of an accessor, if it was given some.
    pub(super) fn decompressed(&self, accessor: usize) -> Option<&Decompressed> {
        self.decompressed.get(&accessor)
    }

    /// Takes them away from all accessors.
    pub(super) fn forget_decompressed(&mut self) {
        self.decompressed.clear();
    }

    /// What a URI leads to.
    pub(super) fn open(
        &mut self,
        uri: &str,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<Vec<u8>, LoadError> {
        let bytes = match Target::of(uri, owner)? {
            Target::Data(bytes) => bytes,
            Target::File(path) => (self.open)(&path)?,
        };
        budget.take(owner, bytes.len() as u64, 1)?;
        Ok(bytes)
    }

    fn buffer(&mut self, index: usize, budget: &mut Budget) -> Result<&[u8], LoadError> {
        let buffer = &self.root.buffers[index];
        let owner = label("buffer", index, buffer.name.as_deref());
        let bytes = match &buffer.uri {
            Some(uri) => {
                if !self.read.contains_key(&index) {
                    let bytes = self.open(uri, &owner, budget)?;
                    self.read.insert(index, bytes);
                }
                &self.read[&index][..]
            }
            None => match self.binary {
                Some(binary) if index == 0 => binary,
                _ => {
                    return Err(LoadError::bad_value(
                        owner,
                        "without a URI",
                        "a URI, or the first buffer of a GLB file with a binary chunk",
                    ));
                }
            },
        };
        let length = buffer.byte_length.0;
        match bytes.get(..usize::try_from(length).unwrap_or(usize::MAX)) {
            Some(bytes) => Ok(bytes),
            None => Err(LoadError::truncated(owner, length, bytes.len())),
        }
    }

    /// Part of a buffer. `what` names it.
    fn part(
        &mut self,
        buffer: Index<buffer::Buffer>,
        start: u64,
        length: u64,
        what: &str,
        budget: &mut Budget,
    ) -> Result<&[u8], LoadError> {
        entry(&self.root.buffers, buffer, what, "buffer")?;
        let end = start.saturating_add(length);
        let bytes = self.buffer(buffer.value(), budget)?;
        if end > bytes.len() as u64 {
            return Err(LoadError::truncated(what, end, bytes.len()));
        }
        Ok(&bytes[start as usize..end as usize])
    }

    /// The bytes of a buffer view.
    pub(super) fn view(
        &mut self,
        index: Index<buffer::View>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<&[u8], LoadError> {
        let view = entry(&self.root.buffer_views, index, owner, "buffer view")?;
        let number = index.value();
        let what = label("buffer view", number, view.name.as_deref());
        let length = view.byte_length.0;
        let value = self.value;
        let compression = || {
            let extensions = value.get("bufferViews")?.get(number)?.get("extensions")?;
            let named = |name| extensions.get(name);
            named("KHR_meshopt_compression").or_else(|| named("EXT_meshopt_compression"))
        };
        let Some(compression) = compression() else {
            let start = view.byte_offset.map_or(0, |offset| offset.0);
            return self.part(view.buffer, start, length, &what, budget);
        };
        if !self.decoded.contains_key(&number) {
            let decoded = self.decompress(compression, &what, budget)?;
            self.decoded.insert(number, decoded);
        }
        let decoded = &self.decoded[&number];
        match decoded.get(..usize::try_from(length).unwrap_or(usize::MAX)) {
            Some(bytes) => Ok(bytes),
            None => Err(LoadError::truncated(what, length, decoded.len())),
        }
    }

    fn decompress(
        &mut self,
        compression: &Value,
        what: &str,
        budget: &mut Budget,
    ) -> Result<Vec<u8>, LoadError> {
        let bad = |field: &str, expected| {
            LoadError::bad_value(
                format!("{field} in the compression of {what}"),
                "missing or unknown",
                expected,
            )
        };
        let number = |field: &str| {
            let number = compression.get(field).and_then(Value::as_u64);
            number.ok_or_else(|| bad(field, "a whole number from 0 up"))
        };
        let name = |field: &str| match compression.get(field) {
            None => Some("NONE"),
            Some(value) => value.as_str(),
        };
        let layout = Layout {
            mode: name("mode")
                .and_then(Mode::from_name)
                .ok_or_else(|| bad("mode", "ATTRIBUTES, TRIANGLES or INDICES"))?,
            filter: name("filter").and_then(Filter::from_name).ok_or_else(|| {
                bad(
                    "filter",
                    "NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL or COLOR",
                )
            })?,
            count: number("count")?,
            stride: number("byteStride")?,
        };
        let buffer =
            u32::try_from(number("buffer")?).map_err(|_| bad("buffer", "the index of a buffer"))?;
        let start = match compression.get("byteOffset") {
            None => 0,
            Some(_) => number("byteOffset")?,
        };
        let length = number("byteLength")?;
        let data = self.part(Index::new(buffer), start, length, what, budget)?;
        layout.decode(data, what, budget)
    }
}
