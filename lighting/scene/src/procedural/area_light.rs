//! A dense curved mesh under a glowing rectangle.

use glam::Vec3;

use super::primitives::torus_grid;
use super::random::{Random, circle};
use super::stage::{Stage, look, paint, pale_fog};
use crate::{AreaLight, Light, Mesh, Scene, Texture};

/// Grid of the knot: 2 · 720 · 72 triangles.
const ALONG: u32 = 720;
const AROUND: u32 = 72;

pub(super) fn build(mut stage: Stage, seed: u64) -> Scene {
    let mut random = Random::new(seed);
    stage.add("knot", knot(random.unit()), paint(0.70, 0.62, 0.50));
    stage.floor();

    let panel = AreaLight {
        texture: Some(warm_to_cold()),
        ..stage.panel(Vec3::new(-0.6, 5.2, -0.45), [1.2, 0.9], Vec3::splat(320.0))
    };
    stage.seen(
        look(Vec3::new(0.0, 3.6, 7.6), Vec3::new(0.0, 2.55, 0.0), 46.0),
        vec![Light::Area(panel)],
        pale_fog(),
    )
}

/// A trefoil knot with ribs, 2 m above the floor.
fn knot(phase: f32) -> Mesh {
    let axis = |u: f32| {
        let (ring, wave) = (circle(2.0 * u + phase), circle(3.0 * u));
        let radius = 1.25 + 0.5 * wave.x;
        Vec3::new(radius * ring.x, 2.4 + 0.55 * wave.y, radius * ring.y)
    };
    torus_grid(ALONG, AROUND, |u, v| {
        let centre = axis(u);
        let along = (axis(u + 1e-3) - axis(u - 1e-3)).normalize();
        // The core of the torus gives a direction that is never along the
        // curve and comes back to itself after one round.
        let ring = circle(2.0 * u + phase);
        let core = Vec3::new(1.25 * ring.x, 2.4, 1.25 * ring.y);
        let out = (centre - core).reject_from_normalized(along).normalize();
        let rib = circle(60.0 * u).x * 0.018 + circle(6.0 * v + 9.0 * u).x * 0.02;
        let p = (0.27 + rib) * circle(v);
        centre + p.x * out + p.y * out.cross(along)
    })
}

fn warm_to_cold() -> Texture {
    let texels = vec![Vec3::new(1.0, 0.55, 0.25), Vec3::new(0.30, 0.55, 1.0)];
    Texture::new(2, 1, texels).expect("numbers of this program")
}
