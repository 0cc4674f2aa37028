//! Which neighbours of a picture see the same surface.

use glam::Vec3;
use gpu_backend::Cpu;

use crate::methods::FrameInputs;
use crate::methods::reduced::resemblance::{FARTHEST, Plane, Seen, planes};
use crate::scene::Bounds;
use crate::{Interval, Ray};

/// Neighbours that resemble each other less than this are on two sides of a
/// discontinuity.
const ALIKE: f32 = 0.5;

const RIGHT: u8 = 1;
const BELOW: u8 = 2;

/// The faces of a box through which a ray enters and leaves it, from 1 on; 0 for an end
/// inside.
type Faces = [u8; 2];

/// The faces of a ray that misses the box.
const OUTSIDE: Faces = [u8::MAX; 2];

/// What the pixels of a picture see, and where that is discontinuous: in depth, or by a
/// sharp turn of the surface, at which the light of a pixel has a kink. The faces of a
/// bounded medium are surfaces too.
#[derive(Debug)]
pub(super) struct Surfaces<'a> {
    inputs: FrameInputs<'a>,
    planes: Vec<Plane>,
    /// Through which faces each ray runs of the box that the medium fills; empty if it
    /// is everywhere.
    faces: Vec<Faces>,
    /// Whether something begins to the right of a pixel, or below it.
    edges: Vec<u8>,
}

impl<'a> Surfaces<'a> {
    /// Those of a whole picture, of as many rays and hits as pixels.
    pub(super) fn new(cpu: &Cpu, inputs: &FrameInputs<'a>) -> Self {
        let planes = planes(cpu, inputs);
        let mut surfaces = Self {
            inputs: *inputs,
            planes,
            faces: Vec::new(),
            edges: Vec::new(),
        };
        if let Some(bounds) = inputs.medium.bounds() {
            surfaces.faces = cpu.map(inputs.rays.len(), |i| faces(&bounds, &inputs.rays[i]));
        }
        let [columns, rows] = inputs.size.map(|side| side as usize);
        surfaces.edges = cpu.map(inputs.rays.len(), |pixel| {
            let differs = |other| {
                let triangle = |i: usize| inputs.hits[i].map(|hit| hit.triangle);
                let is_one = surfaces.faces.is_empty()
                    && triangle(pixel).is_some()
                    && triangle(pixel) == triangle(other);
                !is_one && surfaces.resemblance(pixel, other) < ALIKE
            };
            let right = pixel % columns + 1 < columns && differs(pixel + 1);
            let below = pixel / columns + 1 < rows && differs(pixel + columns);
            u8::from(right) * RIGHT + u8::from(below) * BELOW
        });
        surfaces
    }

    /// The frame.
    pub(super) fn inputs(&self) -> &FrameInputs<'a> {
        &self.inputs
    }

    /// How much two pixels see alike, from 0 to 1.
    pub(super) fn resemblance(&self, a: usize, b: usize) -> f32 {
        if a == b {
            return 1.0;
        }
        if let (Some(of_a), Some(of_b)) = (self.faces.get(a), self.faces.get(b)) {
            if of_a != of_b {
                return 0.0;
            }
            // What is behind the box does not matter.
            if of_a[1] != 0 {
                return 1.0;
            }
        }
        let seen = Seen {
            rays: self.inputs.rays,
            planes: &self.planes,
            matters: true,
        };
        seen.resemblance(a, b).min(seen.resemblance(b, a))
    }

    /// Whether there is a discontinuity between two pixels that touch, also by a corner.
    pub(super) fn is_edge(&self, [x, y]: [u32; 2], [to_x, to_y]: [u32; 2]) -> bool {
        let columns = self.inputs.size[0];
        let flag = |x: u32, y: u32, side| self.edges[(y * columns + x) as usize] & side != 0;
        let across = |y| x != to_x && flag(x.min(to_x), y, RIGHT);
        let down = |x| y != to_y && flag(x, y.min(to_y), BELOW);
        // Around a corner both ways have to be blocked.
        (across(y) || down(to_x)) && (down(x) || across(to_y))
    }

    /// The length of a ray from the eye through a point of a pixel: up to the plane that
    /// the pixel sees.
    pub(super) fn length(&self, pixel: usize, direction: Vec3) -> f32 {
        let own = self.inputs.rays[pixel].length();
        let [x, y, z, h] = self.planes[pixel];
        if h == 0.0 || own >= FARTHEST {
            return own;
        }
        let inverse = direction.dot(Vec3::new(x, y, z));
        // Half a pixel changes it by more at the horizon of a plane alone.
        if inverse > 0.0 {
            (1.0 / inverse).clamp(0.5 * own, 2.0 * own)
        } else {
            own
        }
    }
}

/// The faces through which a ray runs.
fn faces(bounds: &Bounds, ray: &Ray) -> Faces {
    let whole = Interval::new(0.0, ray.length());
    let Some(inside) = bounds.clip(ray.origin(), ray.direction(), whole) else {
        return OUTSIDE;
    };
    let closest = |distance: f32| {
        let point = ray.at(distance);
        let [below, above] = [point - bounds.min(), bounds.max() - point];
        let gaps = [below.x, below.y, below.z, above.x, above.y, above.z];
        let closest = (1..)
            .zip(gaps)
            .min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        closest.map_or(0, |(face, _)| face)
    };
    let is_cut = [inside.start > 0.0, inside.end < ray.length()];
    [
        if is_cut[0] { closest(inside.start) } else { 0 },
        if is_cut[1] { closest(inside.end) } else { 0 },
    ]
}
