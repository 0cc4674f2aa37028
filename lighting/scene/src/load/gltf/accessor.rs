//! The arrays that accessors describe.

use glam::{Vec2, Vec3, Vec4};
use gltf_json::accessor::{Accessor, ComponentType, Type};
use gltf_json::validation::Checked;
use gltf_json::{Index, buffer};

use super::buffers::Buffers;
use super::draco::Decompressed;
use super::{entry, label};
use crate::load::LoadError;
use crate::load::limits::Budget;

/// Numbers in a buffer view; all of them are known to be there.
#[derive(Debug, Clone, Copy)]
struct Layout {
    component: ComponentType,
    /// Integers stand for −1 to 1 or 0 to 1.
    normalized: bool,
    /// Bytes between elements.
    stride: usize,
    start: usize,
    count: usize,
}

impl Layout {
    /// Component `number` of the element at the front of `bytes`.
    fn component(&self, bytes: &[u8], number: usize) -> f32 {
        let signed = |value: f32, one: f32| match self.normalized {
            true => (value / one).max(-1.0),
            false => value,
        };
        let unsigned = |value: f32, one: f32| match self.normalized {
            true => value / one,
            false => value,
        };
        let short = || [bytes[2 * number], bytes[2 * number + 1]];
        match self.component {
            ComponentType::I8 => signed(f32::from(bytes[number] as i8), 127.0),
            ComponentType::U8 => unsigned(f32::from(bytes[number]), 255.0),
            ComponentType::I16 => signed(f32::from(i16::from_le_bytes(short())), 32767.0),
            ComponentType::U16 => unsigned(f32::from(u16::from_le_bytes(short())), 65535.0),
            // Nothing but indices is of this type, and those are read as such.
            ComponentType::U32 => index(bytes, 4) as f32,
            ComponentType::F32 => f32::from_bits(index(&bytes[4 * number..], 4)),
        }
    }

    fn elements<'a>(&self, bytes: &'a [u8]) -> impl Iterator<Item = &'a [u8]> {
        let Self { start, stride, .. } = *self;
        (0..self.count).map(move |number| &bytes[start + number * stride..])
    }
}

/// A little-endian number of `size` bytes: 1, 2 or 4.
fn index(bytes: &[u8], size: usize) -> u32 {
    let mut number = [0; 4];
    number[..size].copy_from_slice(&bytes[..size]);
    u32::from_le_bytes(number)
}

/// What may be in an accessor.
struct Expected {
    shape: Type,
    components: &'static [ComponentType],
    /// What the accessor's `normalized` is taken for; `None` is as it says.
    normalized: Option<bool>,
    /// What to say of other components.
    message: &'static str,
}

impl Decompressed {
    /// Where its elements are, if they are what is expected.
    fn layout(
        &self,
        expected: &Expected,
        multiplicity: usize,
        normalized: bool,
        what: &str,
    ) -> Result<Layout, LoadError> {
        if !expected.components.contains(&self.component) {
            return Err(LoadError::bad_value(
                format!("the component type of {what}"),
                format!("{:?}", self.component),
                expected.message,
            ));
        }
        let stride = self.component.size() * multiplicity;
        let count = self.bytes.len() / stride;
        if count as u64 != self.count || count * stride != self.bytes.len() {
            return Err(LoadError::bad_value(
                format!("the compressed data of {what}"),
                format!("{} bytes for {} elements", self.bytes.len(), self.count),
                "as many components as the accessor has",
            ));
        }
        Ok(Layout {
            component: self.component,
            normalized,
            stride,
            start: 0,
            count,
        })
    }
}

impl Buffers<'_> {
    /// Checks where an array is and that all of it is there.
    #[expect(
        clippy::too_many_arguments,
        reason = "each is a property of the array that the document states"
    )]
    fn layout(
        &mut self,
        view: Index<buffer::View>,
        start: u64,
        component: ComponentType,
        multiplicity: usize,
        normalized: bool,
        count: u64,
        what: &str,
        budget: &mut Budget,
    ) -> Result<Layout, LoadError> {
        let size = component.size() * multiplicity;
        let owner = entry(&self.root.buffer_views, view, what, "buffer view")?;
        let stride = owner.byte_stride.map_or(size, |stride| stride.0);
        if stride < size {
            return Err(LoadError::bad_value(
                format!("the stride of {what}"),
                stride,
                "at least the size of an element",
            ));
        }
        let needed = match count {
            0 => 0,
            _ => (count - 1)
                .saturating_mul(stride as u64)
                .saturating_add(size as u64)
                .saturating_add(start),
        };
        let available = self.view(view, what, budget)?.len();
        if needed > available as u64 {
            return Err(LoadError::truncated(what, needed, available));
        }
        Ok(Layout {
            component,
            normalized,
            stride,
            start: if count == 0 { 0 } else { start as usize },
            count: count as usize,
        })
    }

    /// The elements of an accessor, each made by `read` from its layout and
    /// bytes; those that are in no buffer are `zero`.
    fn array<T: Copy>(
        &mut self,
        accessor: Index<Accessor>,
        owner: &str,
        expected: &Expected,
        zero: T,
        read: impl Fn(&Layout, &[u8]) -> T,
        budget: &mut Budget,
    ) -> Result<Vec<T>, LoadError> {
        let root = self.root;
        let number = accessor.value();
        let accessor = entry(&root.accessors, accessor, owner, "accessor")?;
        let name = label("accessor", number, accessor.name.as_deref());
        let what = format!("{name} of {owner}");
        let Expected { shape, .. } = *expected;
        if accessor.type_ != Checked::Valid(shape) {
            return Err(LoadError::bad_value(
                format!("the type of {what}"),
                match accessor.type_ {
                    Checked::Valid(other) => format!("{other:?}").to_uppercase(),
                    Checked::Invalid => "unknown".into(),
                },
                match shape {
                    Type::Scalar => "SCALAR",
                    Type::Vec2 => "VEC2",
                    Type::Vec4 => "VEC4",
                    _ => "VEC3",
                },
            ));
        }
        let multiplicity = shape.multiplicity();
        let normalized = expected.normalized.unwrap_or(accessor.normalized);
        if let Some(elements) = self.decompressed(number) {
            let layout = elements.layout(expected, multiplicity, normalized, &what)?;
            budget.take(owner, elements.count, size_of::<T>())?;
            let bytes = layout.elements(&elements.bytes);
            return Ok(bytes.map(|element| read(&layout, element)).collect());
        }
        let Checked::Valid(component) = &accessor.component_type else {
            return Err(LoadError::bad_value(
                format!("the component type of {what}"),
                "unknown",
                "5120 to 5126",
            ));
        };
        let component = component.0;
        if !expected.components.contains(&component) {
            return Err(LoadError::bad_value(
                format!("the component type of {what}"),
                format!("{component:?}"),
                expected.message,
            ));
        }
        let count = accessor.count.0;
        let mut elements = match accessor.buffer_view {
            Some(view) => {
                let start = accessor.byte_offset.map_or(0, |offset| offset.0);
                let layout = self.layout(
                    view,
                    start,
                    component,
                    multiplicity,
                    normalized,
                    count,
                    &what,
                    budget,
                )?;
                budget.take(owner, count, size_of::<T>())?;
                let bytes = self.view(view, &what, budget)?;
                layout.elements(bytes).map(|e| read(&layout, e)).collect()
            }
            None => {
                // No bytes of the file stand behind the count.
                budget.take(owner, count, size_of::<T>().saturating_mul(ZEROS))?;
                vec![zero; count as usize]
            }
        };
        let Some(sparse) = &accessor.sparse else {
            return Ok(elements);
        };
        let Checked::Valid(index_component) = &sparse.indices.component_type else {
            return Err(LoadError::bad_value(
                format!("the component type of the sparse indices of {what}"),
                "unknown",
                "unsigned byte, short or int",
            ));
        };
        let size = index_component.0.size();
        let of_indices = self.layout(
            sparse.indices.buffer_view,
            sparse.indices.byte_offset.0,
            index_component.0,
            1,
            false,
            sparse.count.0,
            &format!("the sparse indices of {what}"),
            budget,
        )?;
        budget.take(owner, sparse.count.0, size_of::<usize>())?;
        let bytes = self.view(sparse.indices.buffer_view, &what, budget)?;
        let places: Vec<usize> = of_indices
            .elements(bytes)
            .map(|element| index(element, size) as usize)
            .collect();
        if let Some(place) = places.iter().find(|place| **place >= elements.len()) {
            return Err(LoadError::bad_value(
                format!("a sparse index of {what}"),
                place,
                "below the number of its elements",
            ));
        }
        let of_values = self.layout(
            sparse.values.buffer_view,
            sparse.values.byte_offset.0,
            component,
            multiplicity,
            normalized,
            sparse.count.0,
            &format!("the sparse values of {what}"),
            budget,
        )?;
        let bytes = self.view(sparse.values.buffer_view, &what, budget)?;
        for (place, element) in places.into_iter().zip(of_values.elements(bytes)) {
            elements[place] = read(&of_values, element);
        }
        Ok(elements)
    }

    /// Vertex positions, or what is added to them.
    pub(super) fn positions(
        &mut self,
        index: Index<Accessor>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<Vec<Vec3>, LoadError> {
        let expected = Expected {
            shape: Type::Vec3,
            components: if self.quantised { QUANTISED } else { FLOAT },
            normalized: None,
            message: "float, or with KHR_mesh_quantization byte or short",
        };
        self.array(index, owner, &expected, Vec3::ZERO, vec3, budget)
    }

    /// Texture coordinates.
    pub(super) fn texture_coordinates(
        &mut self,
        index: Index<Accessor>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<Vec<Vec2>, LoadError> {
        let owner = format!("the texture coordinates of {owner}");
        let expected = Expected {
            shape: Type::Vec2,
            components: if self.quantised { QUANTISED } else { UNIT },
            normalized: (!self.quantised).then_some(true),
            message: "float, unsigned byte or unsigned short",
        };
        let read = |layout: &Layout, bytes: &[u8]| {
            Vec2::new(layout.component(bytes, 0), layout.component(bytes, 1))
        };
        self.array(index, &owner, &expected, Vec2::ZERO, read, budget)
    }

    /// Vertex colours; opaque if they have no alpha.
    pub(super) fn colors(
        &mut self,
        index: Index<Accessor>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<Vec<Vec4>, LoadError> {
        let owner = format!("the vertex colours of {owner}");
        let accessor = entry(&self.root.accessors, index, &owner, "accessor")?;
        let has_alpha = accessor.type_ == Checked::Valid(Type::Vec4);
        let expected = Expected {
            shape: if has_alpha { Type::Vec4 } else { Type::Vec3 },
            components: UNIT,
            normalized: Some(true),
            message: "float, unsigned byte or unsigned short",
        };
        let read = |layout: &Layout, bytes: &[u8]| {
            let color = vec3(layout, bytes);
            color.extend(if has_alpha {
                layout.component(bytes, 3)
            } else {
                1.0
            })
        };
        let zero = Vec3::ZERO.extend(if has_alpha { 0.0 } else { 1.0 });
        self.array(index, &owner, &expected, zero, read, budget)
    }

    /// Translations or scales of instances.
    pub(super) fn vectors(
        &mut self,
        index: Index<Accessor>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<Vec<Vec3>, LoadError> {
        let expected = Expected {
            shape: Type::Vec3,
            components: FLOAT,
            normalized: Some(false),
            message: "float",
        };
        self.array(index, owner, &expected, Vec3::ZERO, vec3, budget)
    }

    /// Rotations of instances.
    pub(super) fn rotations(
        &mut self,
        index: Index<Accessor>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<Vec<Vec4>, LoadError> {
        let expected = Expected {
            shape: Type::Vec4,
            components: &[ComponentType::F32, ComponentType::I8, ComponentType::I16],
            normalized: Some(true),
            message: "float, byte or short",
        };
        self.array(index, owner, &expected, Vec4::ZERO, vec4, budget)
    }

    /// Weights of joints.
    pub(super) fn weights(
        &mut self,
        index: Index<Accessor>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<Vec<Vec4>, LoadError> {
        let expected = Expected {
            shape: Type::Vec4,
            components: UNIT,
            normalized: Some(true),
            message: "float, unsigned byte or unsigned short",
        };
        self.array(index, owner, &expected, Vec4::ZERO, vec4, budget)
    }

    /// Numbers of joints.
    pub(super) fn joints(
        &mut self,
        accessor: Index<Accessor>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<Vec<[u16; 4]>, LoadError> {
        let expected = Expected {
            shape: Type::Vec4,
            components: &[ComponentType::U8, ComponentType::U16],
            normalized: Some(false),
            message: "unsigned byte or unsigned short",
        };
        let read = |layout: &Layout, bytes: &[u8]| {
            let size = layout.component.size();
            [0, 1, 2, 3].map(|number| index(&bytes[size * number..], size) as u16)
        };
        self.array(accessor, owner, &expected, [0; 4], read, budget)
    }

    /// Matrices, column by column.
    pub(super) fn matrices(
        &mut self,
        index: Index<Accessor>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<Vec<[f32; 16]>, LoadError> {
        let expected = Expected {
            shape: Type::Mat4,
            components: FLOAT,
            normalized: Some(false),
            message: "float",
        };
        let read = |layout: &Layout, bytes: &[u8]| {
            std::array::from_fn(|number| layout.component(bytes, number))
        };
        self.array(index, owner, &expected, [0.0; 16], read, budget)
    }

    /// Vertex indices.
    pub(super) fn indices(
        &mut self,
        accessor: Index<Accessor>,
        owner: &str,
        budget: &mut Budget,
    ) -> Result<Vec<u32>, LoadError> {
        let owner = format!("the indices of {owner}");
        let expected = Expected {
            shape: Type::Scalar,
            components: &[ComponentType::U8, ComponentType::U16, ComponentType::U32],
            normalized: Some(false),
            message: "unsigned byte, short or int",
        };
        let read = |layout: &Layout, bytes: &[u8]| index(bytes, layout.component.size());
        self.array(accessor, &owner, &expected, 0, read, budget)
    }
}

/// Elements that no bytes stand behind count as this many, so that a short file
/// cannot ask for more than 1/64 of [`MAX_DECODED_BYTES`] that way.
///
/// [`MAX_DECODED_BYTES`]: crate::load::MAX_DECODED_BYTES
const ZEROS: usize = 64;

const FLOAT: &[ComponentType] = &[ComponentType::F32];

/// From 0 to 1.
const UNIT: &[ComponentType] = &[ComponentType::F32, ComponentType::U8, ComponentType::U16];

/// `KHR_mesh_quantization`.
const QUANTISED: &[ComponentType] = &[
    ComponentType::F32,
    ComponentType::I8,
    ComponentType::U8,
    ComponentType::I16,
    ComponentType::U16,
];

fn vec3(layout: &Layout, bytes: &[u8]) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|number| layout.component(bytes, number)))
}

fn vec4(layout: &Layout, bytes: &[u8]) -> Vec4 {
    Vec4::from_array([0, 1, 2, 3].map(|number| layout.component(bytes, number)))
}
