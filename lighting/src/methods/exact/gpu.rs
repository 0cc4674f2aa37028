//! Exact visibility in shaders.
//!
//! A shader walks the hierarchy of the triangles without a stack, as a [`Preorder`] has it,
//! and keeps the 16 dark intervals of a ray that are nearest: what lies behind them is found
//! by another walk, so there is no ray for which they are too few. The time of a ray with many
//! shadows grows with the square of their number: thousands of blades, one behind the other,
//! may take longer than a driver allows.
//!
//! Coordinates are f32 and begin at the light; under a sun, at the eye. A direction from the
//! light is off by some 10⁻⁶ rad times `D / h`, the distance of the eye from the light over
//! that of the ray, and the ends of lit parts move with it; under a sun ends are off by some
//! 10⁻⁶ of how far the blocker is. A blocker closer than 10⁻⁶ of its own size to a line
//! through the light may count as seen edge-on, and block nothing.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, Encode, Gpu, GpuBuffer, InShader};
use gpu_backend::shader::Part;
#[cfg(feature = "translucent")]
use gpu_backend::shader::Slot;
use gpu_backend::{Backend, Element, Error};

use crate::gpu::VisibilitySlot;
use crate::scene::Caster;
#[cfg(feature = "methods")]
use crate::scene::Coatings;
use crate::scene::trace::{Preorder, PreorderNode, Tracer};

/// `light_Exact` of `triangles.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct ExactRecord {
    pub(crate) nodes: u32,
    pub(crate) padding_a: u32,
    pub(crate) padding_b: u32,
    pub(crate) padding_c: u32,
}

/// [`Exact`](super::Exact) where shaders ask it: the triangles of a scene and their
/// hierarchy, in the memory of a GPU.
///
/// It answers for any light. Drivers in software end the loops of a ray after 65,535 turns, and
/// what is left of it would be lit: with them, gather through no more than 150 triangles, and
/// trace shadow rays through no more than 20,000. All triangles are solid or cast no shadow. A
/// triangle takes 36 bytes, a node of the hierarchy 32.
#[derive(Debug)]
pub struct UploadedTracer {
    nodes: GpuBuffer<PreorderNode>,
    corners: GpuBuffer<f32>,
    node_count: u32,
    bytes: u64,
}

/// Why triangles are not where shaders could ask about them.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UploadTracerError {
    /// Part of the light passes through a triangle.
    #[error("triangle {triangle} is masked or see-through, expected solid ones")]
    NotSolid {
        /// Index into [`Geometry::triangles`](crate::scene::Geometry::triangles).
        triangle: usize,
    },
    /// The backend failed: [`Error::TooLarge`] if a GPU cannot bind as much at once.
    #[error(transparent)]
    Backend(#[from] Error),
}

impl UploadedTracer {
    /// Copies the triangles of a tracer to a GPU.
    ///
    /// # Errors
    /// [`UploadTracerError`].
    pub fn new<E: Encode>(gpu: &Gpu<E>, tracer: &Tracer) -> Result<Self, UploadTracerError> {
        let mut not_solid: Option<usize> = None;
        let Preorder { nodes, triangles } = tracer.preorder(|index| {
            let caster = tracer.coatings().caster(index);
            if !is_in_shaders(&caster) {
                not_solid = Some(not_solid.map_or(index, |first| first.min(index)));
            }
            caster != Caster::Absent
        });
        if let Some(triangle) = not_solid {
            return Err(UploadTracerError::NotSolid { triangle });
        }
        let corners: &[f32] = bytemuck::cast_slice(&triangles);
        Ok(Self {
            // A tracer holds fewer nodes than a u32 counts.
            node_count: nodes.len() as u32,
            bytes: (size_of_val(&nodes[..]) + size_of_val(corners)) as u64,
            nodes: upload(gpu, "the hierarchy of the triangles", &nodes)?,
            corners: upload(gpu, "the corners of the triangles", corners)?,
        })
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

/// Whether the shader knows what a triangle does to light.
fn is_in_shaders(caster: &Caster<'_>) -> bool {
    matches!(caster, Caster::Solid | Caster::Absent)
}

/// Whether the shader knows what each of so many triangles does to light.
#[cfg(feature = "methods")]
pub(super) fn are_in_shaders(coatings: &Coatings, triangles: usize) -> bool {
    coatings.all_solid() || (0..triangles).all(|index| is_in_shaders(&coatings.caster(index)))
}

/// Copies to a GPU, whose error says what is too large.
fn upload<T: Element, E: Encode>(
    gpu: &Gpu<E>,
    what: &'static str,
    data: &[T],
) -> Result<GpuBuffer<T>, Error> {
    gpu.upload(data).map_err(|error| match error {
        Error::TooLarge {
            requested, limit, ..
        } => Error::TooLarge {
            what,
            requested,
            limit,
        },
        other => other,
    })
}

/// The triangles, and what asks about them.
fn part(question: &'static str) -> Part {
    Part::new("light_exact")
        .sources(&[include_str!("triangles.wgsl"), question])
        .uniform("light_exact", "light_Exact")
        .read("light_exact_nodes", "array<light_exact_Node>")
        .read("light_exact_corners", "array<f32>")
}

impl UploadedTracer {
    fn bindings(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(ExactRecord {
                nodes: self.node_count,
                padding_a: 0,
                padding_b: 0,
                padding_c: 0,
            }),
            Argument::read(&self.nodes),
            Argument::read(&self.corners),
        ]
    }
}

impl InShader<VisibilitySlot> for UploadedTracer {
    fn part() -> Part {
        part(include_str!("exact.wgsl"))
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        self.bindings()
    }
}

/// The slot for the question: *is no triangle between this point and another one?* A part `x`
/// defines
///
/// ```wgsl
/// fn x_is_open(origin: vec3<f32>, direction: vec3<f32>, length: f32) -> bool
/// ```
///
/// for a unit vector as direction and a length that may be `light_FAR`.
#[cfg(feature = "translucent")]
#[derive(Debug)]
pub(crate) struct ShadowRaySlot;

#[cfg(feature = "translucent")]
impl Slot for ShadowRaySlot {
    fn glue(part: &str) -> String {
        format!(
            "
fn light_shadow_ray_is_open(origin: vec3<f32>, direction: vec3<f32>, length: f32) -> bool {{
    return {part}_is_open(origin, direction, length);
}}
"
        )
    }
}

/// A shadow ray takes a turn for each node that it looks at and each triangle of a leaf, at most
/// three for each triangle of the scene.
#[cfg(feature = "translucent")]
impl InShader<ShadowRaySlot> for UploadedTracer {
    fn part() -> Part {
        part(include_str!("shadow_ray.wgsl"))
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        self.bindings()
    }
}
