//! What the pixels of a picture see, and which of them see alike.

use glam::Vec3;
use gpu_backend::Cpu;

use crate::Ray;
use crate::methods::FrameInputs;

/// Relative difference of lengths, times this, from which on two pixels have nothing in
/// common.
pub(super) const PER_LENGTH: f32 = 10.0;

/// The same for 1 − cos of the angle between normals: 53°.
pub(super) const PER_TURN: f32 = 2.5;

/// Lengths of rays, at most: what is behind is the sky.
pub(in crate::methods) const FARTHEST: f32 = 1e18;

/// Surfaces that a ray meets at a smaller cosine than this count as facing the eye:
/// their plane says too little.
const EDGE_ON: f32 = 5e-3;

/// The plane of the surface that a pixel sees: the vector q of the points P with
/// q · P = 1, seen from the eye, and the distance h of the eye from it, 1 / |q|; zeros
/// for the sky.
pub(in crate::methods) type Plane = [f32; 4];

/// What each pixel of a frame sees. Surfaces without a known triangle face the eye.
pub(in crate::methods) fn planes(cpu: &Cpu, inputs: &FrameInputs<'_>) -> Vec<Plane> {
    cpu.map(inputs.rays.len(), |pixel| {
        let ray = &inputs.rays[pixel];
        if ray.length() >= FARTHEST {
            return [0.0; 4];
        }
        let length = ray.length().max(1.0 / FARTHEST);
        let hit = inputs.hits.get(pixel).copied().flatten();
        let corners = hit.and_then(|hit| inputs.geometry.triangles().get(hit.triangle as usize));
        if let Some([a, b, c]) = corners {
            let normal = (*b - *a).cross(*c - *a).normalize_or_zero();
            let cosine = normal.dot(ray.direction());
            if cosine.abs() > EDGE_ON {
                let h = length * cosine;
                return (normal / h).extend(h.abs()).to_array();
            }
        }
        (ray.direction() / length).extend(length).to_array()
    })
}

/// What pixels see, and where they look.
#[derive(Debug, Clone, Copy)]
pub(in crate::methods) struct Seen<'a> {
    pub(in crate::methods) rays: &'a [Ray],
    pub(in crate::methods) planes: &'a [Plane],
    /// Whether what they see matters at all.
    pub(in crate::methods) matters: bool,
}

/// Tukey's biweight.
#[inline]
fn biweight(e: f32) -> f32 {
    let e = e.min(2.0);
    let left = (1.0 - e * e).max(0.0);
    left * left
}

impl Seen<'_> {
    /// How much what `sample` sees is like what `pixel` sees, from 0 to 1.
    #[inline]
    pub(in crate::methods) fn resemblance(&self, pixel: usize, sample: usize) -> f32 {
        if !self.matters {
            return 1.0;
        }
        let [here, there] = [pixel, sample].map(|index| self.planes[index]);
        if here[3] == 0.0 || there[3] == 0.0 {
            return f32::from(u8::from(here[3] == there[3]));
        }
        let [q_here, q_there] = [here, there].map(|plane| Vec3::new(plane[0], plane[1], plane[2]));
        let ray = &self.rays[sample];
        let ratio = ray.length().min(FARTHEST) * q_here.dot(ray.direction());
        let cosine = q_here.dot(q_there) * here[3] * there[3];
        biweight(PER_LENGTH * (ratio - 1.0).abs()) * biweight(PER_TURN * (1.0 - cosine))
    }
}
