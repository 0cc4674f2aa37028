//! `KHR_draco_mesh_compression`: primitives that are there compressed alone.
//!
//! What comes out takes the place of the accessors that the primitive names.
//! Nothing is decoded where these have data of their own.

use draco_core::{
    DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute, PointIndex,
};
use gltf_json::accessor::ComponentType;
use gltf_json::mesh::{Mode, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Value};

use super::{Builder, extras};
use crate::MAX_TRIANGLES;
use crate::load::LoadError;
use crate::load::limits::Budget;

/// The extension.
pub(super) const NAME: &str = "KHR_draco_mesh_compression";

/// Bytes that the decoder needs for each triangle and each point beside what comes
/// out: its tables of corners and of neighbours, rounded up.
const WORK: u64 = 128;

/// The elements of an accessor, one after the other.
#[derive(Debug)]
pub(super) struct Decompressed {
    pub(super) component: ComponentType,
    pub(super) count: u64,
    pub(super) bytes: Vec<u8>,
}

impl<'a> Builder<'a> {
    /// True if a primitive is there only compressed.
    pub(super) fn is_compressed(&self, mesh: usize, number: usize) -> bool {
        let primitive = &self.root.meshes[mesh].primitives[number];
        let accessors = primitive.attributes.values().copied();
        self.draco(mesh, number).is_some()
            && accessors.chain(primitive.indices).any(|index| {
                let accessor = self.root.accessors.get(index.value());
                accessor.is_some_and(|a| a.buffer_view.is_none() && a.sparse.is_none())
            })
    }

    /// The extension of a primitive, if it has it.
    fn draco(&self, mesh: usize, number: usize) -> Option<&'a Value> {
        let value = self.value;
        let mesh = value.get("meshes")?.get(mesh)?;
        let primitive = mesh.get("primitives")?.get(number)?;
        primitive.get("extensions")?.get(NAME)
    }

    /// Puts what a primitive consists of in the place of its accessors.
    pub(super) fn decompress(
        &mut self,
        mesh: usize,
        number: usize,
        name: &str,
    ) -> Result<(), LoadError> {
        let what = format!("the compressed data of {name}");
        let bad = |what: String, value: &str, expected| LoadError::bad_value(what, value, expected);
        let root = self.root;
        let primitive = &root.meshes[mesh].primitives[number];
        if primitive.mode != Checked::Valid(Mode::Triangles) {
            return Err(LoadError::Unsupported(format!(
                "{NAME} of anything but lists of triangles, as in {name},"
            )));
        }
        let extension = self.draco(mesh, number);
        let whole = |value: Option<&Value>, what: String| {
            let number = value.and_then(Value::as_u64);
            let number = number.and_then(|number| u32::try_from(number).ok());
            number.ok_or_else(|| {
                bad(
                    what,
                    value.map_or("missing", extras::kind),
                    "a whole number from 0 up",
                )
            })
        };
        let field = |name: &str| extension.and_then(|extension| extension.get(name));
        let view = whole(field("bufferView"), format!("the buffer view of {what}"))?;
        let mut wanted = Vec::new();
        for (semantic, accessor) in &primitive.attributes {
            let Checked::Valid(semantic) = semantic else {
                continue;
            };
            // Normals and tangents are nobody's concern here.
            if matches!(semantic, Semantic::Normals | Semantic::Tangents) {
                continue;
            }
            let id = field("attributes").and_then(|list| list.get(semantic.to_string()));
            if let Some(id) = id {
                let id = whole(Some(id), format!("{} in {what}", semantic.to_string()))?;
                wanted.push((*accessor, id, semantic.to_string()));
            }
        }
        let Some(corners) = primitive.indices else {
            return Err(bad(
                format!("the indices of {name}"),
                "missing",
                "an accessor, as of every compressed primitive",
            ));
        };
        let bytes = self
            .buffers
            .view(Index::new(view), &what, &mut self.budget)?;
        let decoded = decode(bytes, &what, &self.budget)?;
        let points = decoded.num_points();
        for (accessor, id, semantic) in wanted {
            let what = format!("{semantic} in {what}");
            let Some(attribute) = decoded.attribute_by_unique_id(id) else {
                return Err(bad(
                    what,
                    "not there",
                    "the number of an attribute of the data",
                ));
            };
            let elements = elements(attribute, points, &what, &mut self.budget)?;
            self.buffers.put(accessor, elements);
        }
        let corner_count = 3 * decoded.num_faces() as u64;
        self.budget.take(&what, corner_count, size_of::<u32>())?;
        let bytes = decoded.faces().as_flattened().iter();
        let elements = Decompressed {
            component: ComponentType::U32,
            count: corner_count,
            bytes: bytes.flat_map(|point| point.0.to_le_bytes()).collect(),
        };
        self.buffers.put(corners, elements);
        Ok(())
    }
}

/// The mesh in a stream. It takes no more memory than the budget has.
fn decode(bytes: &[u8], what: &str, budget: &Budget) -> Result<Mesh, LoadError> {
    let left = budget.left();
    let limits = DecodeLimits::default()
        .with_max_points(left / WORK)
        .with_max_faces((left / WORK).min(MAX_TRIANGLES))
        .with_max_decoded_bytes(left / 4);
    let mut mesh = Mesh::new();
    let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
    // Its errors may repeat what is in the file.
    match MeshDecoder::new().decode(&mut buffer, &mut mesh) {
        Ok(()) => Ok(mesh),
        Err(_) => Err(LoadError::bad_value(
            what,
            "damaged or too large",
            "a mesh compressed by Draco",
        )),
    }
}

/// The values of an attribute, point after point.
fn elements(
    attribute: &PointAttribute,
    points: usize,
    what: &str,
    budget: &mut Budget,
) -> Result<Decompressed, LoadError> {
    let component = match attribute.data_type() {
        DataType::Int8 => ComponentType::I8,
        DataType::Uint8 => ComponentType::U8,
        DataType::Int16 => ComponentType::I16,
        DataType::Uint16 => ComponentType::U16,
        DataType::Uint32 => ComponentType::U32,
        DataType::Float32 => ComponentType::F32,
        _ => {
            return Err(LoadError::bad_value(
                format!("the type of {what}"),
                "none of glTF",
                "bytes, shorts, unsigned ints or floats",
            ));
        }
    };
    let size = component.size() * usize::from(attribute.num_components());
    budget.take(what, points as u64, size)?;
    let stored = attribute.buffer().data();
    let stride = usize::try_from(attribute.byte_stride())
        .unwrap_or(0)
        .max(size);
    let mut bytes = Vec::with_capacity(points * size);
    for point in 0..points {
        let value = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
        let start = value.checked_mul(stride);
        let element = start.and_then(|start| stored.get(start..start.checked_add(size)?));
        bytes.extend_from_slice(element.ok_or_else(|| {
            LoadError::bad_value(
                format!("{what} at point {point}"),
                "missing",
                "a value for every point",
            )
        })?);
    }
    Ok(Decompressed {
        component,
        count: points as u64,
        bytes,
    })
}
