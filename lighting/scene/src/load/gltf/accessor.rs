//! Buffers, views of them, and the arrays that accessors describe.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};
use gltf_json::accessor::{Accessor, ComponentType, Type};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root, buffer};

use super::uri::Target;
use super::{OpenFile, entry, label};
use crate::load::LoadError;
use crate::load::limits::Budget;

/// The buffers of a document, read when they are first needed.
pub(super) struct Buffers<'a> {
    root: &'a Root,
    /// The binary chunk of a GLB file.
    binary: Option<&'a [u8]>,
    open: OpenFile<'a>,
    read: BTreeMap<usize, Vec<u8>>,
}

/// An array inside a buffer; all of it is known to be there.
struct Array<'a> {
    bytes: &'a [u8],
    component: ComponentType,
    size: usize,
    stride: usize,
    count: usize,
}

impl Array<'_> {
    fn elements(&self) -> impl Iterator<Item = &[u8]> {
        (0..self.count).map(|i| &self.bytes[i * self.stride..][..self.size])
    }
}

impl<'a> Buffers<'a> {
    pub(super) fn new(root: &'a Root, binary: Option<&'a [u8]>, open: OpenFile<'a>) -> Self {
        Self {
            root,
            binary,
            open,
            read: BTreeMap::new(),
        }
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

    /// The bytes of a buffer view.
    pub(super) fn view(
        &mut self,
        index: Index<buffer::View>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<&[u8], LoadError> {
        let view = entry(&self.root.buffer_views, index, owner, "buffer view")?;
        let what = label("buffer view", index.value(), view.name.as_deref());
        entry(&self.root.buffers, view.buffer, &what, "buffer")?;
        let start = view.byte_offset.map_or(0, |offset| offset.0);
        let end = start.saturating_add(view.byte_length.0);
        let bytes = self.buffer(view.buffer.value(), budget)?;
        let available = bytes.len();
        if end > available as u64 {
            return Err(LoadError::truncated(what, end, available));
        }
        Ok(&bytes[start as usize..end as usize])
    }

    /// The array of an accessor whose elements have the given shape. Memory
    /// for its decoded form is set aside.
    fn array(
        &mut self,
        index: Index<Accessor>,
        owner: &str,
        shape: Type,
        decoded_size: usize,
        budget: &mut Budget,
    ) -> Result<Array<'_>, LoadError> {
        let accessor = entry(&self.root.accessors, index, owner, "accessor")?;
        let name = label("accessor", index.value(), accessor.name.as_deref());
        let what = format!("{name} of {owner}");
        if accessor.type_ != Checked::Valid(shape) {
            return Err(LoadError::bad_value(
                format!("the type of {what}"),
                format!("{:?}", accessor.type_),
                match shape {
                    Type::Scalar => "SCALAR",
                    Type::Vec2 => "VEC2",
                    _ => "VEC3",
                },
            ));
        }
        let Checked::Valid(component) = &accessor.component_type else {
            return Err(LoadError::bad_value(
                format!("the component type of {what}"),
                "unknown",
                "5120 to 5126",
            ));
        };
        let Some(view_index) = accessor.buffer_view.filter(|_| accessor.sparse.is_none()) else {
            return Err(LoadError::Unsupported(format!(
                "{what}, which is sparse or without a buffer view,"
            )));
        };
        let component = component.0;
        let size = component.size() * shape.multiplicity();
        let view = entry(&self.root.buffer_views, view_index, &what, "buffer view")?;
        let stride = view.byte_stride.map_or(size, |stride| stride.0);
        if stride < size {
            return Err(LoadError::bad_value(
                format!("the stride of {what}"),
                stride,
                "at least the size of an element",
            ));
        }
        let start = accessor.byte_offset.map_or(0, |offset| offset.0);
        let count = accessor.count.0;
        let needed = match count {
            0 => 0,
            _ => (count - 1)
                .saturating_mul(stride as u64)
                .saturating_add(size as u64)
                .saturating_add(start),
        };
        let bytes = self.view(view_index, &what, budget)?;
        if needed > bytes.len() as u64 {
            return Err(LoadError::truncated(what, needed, bytes.len()));
        }
        budget.take(owner, count, decoded_size)?;
        Ok(Array {
            bytes: &bytes[if count == 0 { 0 } else { start as usize }..],
            component,
            size,
            stride,
            count: count as usize,
        })
    }

    /// Vertex positions.
    pub(super) fn positions(
        &mut self,
        index: Index<Accessor>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<Vec<Vec3>, LoadError> {
        let array = self.array(index, owner, Type::Vec3, size_of::<Vec3>(), budget)?;
        if array.component != ComponentType::F32 {
            return Err(LoadError::Unsupported(format!(
                "{owner} with positions that are not of type float (KHR_mesh_quantization)"
            )));
        }
        let position = |e: &[u8]| Vec3::new(float(&e[0..]), float(&e[4..]), float(&e[8..]));
        Ok(array.elements().map(position).collect())
    }

    /// Texture coordinates.
    pub(super) fn texture_coordinates(
        &mut self,
        index: Index<Accessor>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<Vec<Vec2>, LoadError> {
        let array = self.array(index, owner, Type::Vec2, size_of::<Vec2>(), budget)?;
        let pair = |e: &[u8], read: fn(&[u8]) -> f32| Vec2::new(read(e), read(&e[e.len() / 2..]));
        let byte = |e: &[u8]| f32::from(e[0]) / 255.0;
        let short = |e: &[u8]| f32::from(u16::from_le_bytes([e[0], e[1]])) / 65535.0;
        Ok(match array.component {
            ComponentType::F32 => array.elements().map(|e| pair(e, float)).collect(),
            ComponentType::U8 => array.elements().map(|e| pair(e, byte)).collect(),
            ComponentType::U16 => array.elements().map(|e| pair(e, short)).collect(),
            other => {
                return Err(LoadError::bad_value(
                    format!("the component type of the texture coordinates of {owner}"),
                    format!("{other:?}"),
                    "float, unsigned byte or unsigned short",
                ));
            }
        })
    }

    /// Vertex indices.
    pub(super) fn indices(
        &mut self,
        index: Index<Accessor>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<Vec<u32>, LoadError> {
        let array = self.array(index, owner, Type::Scalar, size_of::<u32>(), budget)?;
        Ok(match array.component {
            ComponentType::U8 => array.elements().map(|e| e[0].into()).collect(),
            ComponentType::U16 => array
                .elements()
                .map(|e| u16::from_le_bytes([e[0], e[1]]).into())
                .collect(),
            ComponentType::U32 => array
                .elements()
                .map(|e| u32::from_le_bytes([e[0], e[1], e[2], e[3]]))
                .collect(),
            other => {
                return Err(LoadError::bad_value(
                    format!("the component type of the indices of {owner}"),
                    format!("{other:?}"),
                    "unsigned byte, short or int",
                ));
            }
        })
    }
}

fn float(bytes: &[u8]) -> f32 {
    f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}
