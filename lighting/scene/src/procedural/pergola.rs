//! Wide beams under a glowing rectangle: soft shadows that take half of the light.

use glam::Vec3;

use super::primitives::cuboid;
use super::random::Random;
use super::stage::{Stage, look, paint, pale_fog};
use crate::{Light, Scene};

const BEAMS: u32 = 7;
/// From the middle of a beam to the next, m.
const SPACING: f32 = 1.3;

pub(super) fn build(mut stage: Stage, seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let half = 0.5 * SPACING * (BEAMS - 1) as f32;
    let wood = || paint(0.42, 0.33, 0.24);
    for i in 0..BEAMS {
        let x = SPACING * i as f32 - half + random.between(-0.08, 0.08);
        let width = random.between(0.36, 0.46);
        let y = 3.2 + random.between(-0.1, 0.1);
        let beam = cuboid(
            Vec3::new(x - width, y, -2.6),
            Vec3::new(x + width, y + 0.1, 2.6),
        );
        stage.add("beam", beam, wood());
    }
    for side in [-1.0, 1.0] {
        let post = Vec3::new(side * (half + 0.7), 0.0, -2.2);
        let post = cuboid(post - 0.12, post + Vec3::new(0.12, 3.4, 0.12));
        stage.add("post", post, wood());
    }
    stage.floor();

    let panel = stage.panel(
        Vec3::new(-0.7, 5.2, -0.5),
        [1.4, 1.0],
        Vec3::new(330.0, 290.0, 240.0),
    );
    // The light is above the picture, so that no ray passes it closely.
    stage.seen(
        look(Vec3::new(0.6, 2.2, 8.2), Vec3::new(0.0, 1.5, 0.0), 38.0),
        vec![Light::Area(panel)],
        pale_fog(),
    )
}
