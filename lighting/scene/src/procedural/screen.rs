//! Plates and balls under a screen that shows a test card.

use glam::Vec3;

use super::primitives::{cuboid, icosphere};
use super::random::Random;
use super::stage::{Stage, fog, look, paint, upright};
use crate::{AreaLight, Light, PhaseFunction, Scene, Texture};

/// Width and height of the card, texels.
const CARD: [u32; 2] = [14, 8];

/// The screen hangs flat above the picture, so that no ray passes it closely. Its
/// colours lie metres apart from each other's shadows; a fifth of it is black.
pub(super) fn build(mut stage: Stage, seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let ball = stage.shape("ball", icosphere(3), paint(0.6, 0.6, 0.6));
    for row in 0..3 {
        for column in 0..5 {
            let shift = Vec3::new(
                random.between(-0.15, 0.15),
                0.0,
                random.between(-0.15, 0.15),
            );
            let x = 1.25 * (column as f32 - 2.0);
            let z = 1.2 * (row as f32 - 1.0);
            let place = Vec3::new(x, random.between(2.9, 3.4), z) + shift;
            if (row + column) % 2 == 0 {
                let half = Vec3::new(random.between(0.3, 0.45), 0.03, random.between(0.3, 0.45));
                stage.add(
                    "plate",
                    cuboid(place - half, place + half),
                    paint(0.5, 0.45, 0.4),
                );
            } else {
                let radius = random.between(0.2, 0.32);
                stage.place(ball, upright(Vec3::splat(radius), random.unit(), place));
            }
        }
    }
    let floor = cuboid(Vec3::new(-12.0, -0.3, -12.0), Vec3::new(12.0, 0.0, 12.0));
    stage.add("floor", floor, paint(0.55, 0.55, 0.55));

    let screen = AreaLight {
        texture: Some(card()),
        ..stage.panel(Vec3::new(-1.4, 5.0, -0.8), [2.8, 1.6], Vec3::splat(160.0))
    };
    stage.seen(
        look(Vec3::new(0.5, 2.3, 8.4), Vec3::new(0.0, 1.7, 0.0), 40.0),
        vec![Light::Area(screen)],
        fog(
            Vec3::splat(0.10),
            Vec3::splat(0.01),
            PhaseFunction::Isotropic,
        ),
    )
}

/// Seven colour bars of full and of half strength below each other, as EBU bars
/// without the white one's pedestal, above a black stripe with a bright spot.
fn card() -> Texture {
    let [width, height] = CARD;
    let bar = |column: u32| match column * 7 / width {
        0 => Vec3::ONE,
        1 => Vec3::new(1.0, 1.0, 0.02),
        2 => Vec3::new(0.02, 1.0, 1.0),
        3 => Vec3::new(0.02, 1.0, 0.02),
        4 => Vec3::new(1.0, 0.02, 1.0),
        5 => Vec3::new(1.0, 0.02, 0.02),
        _ => Vec3::new(0.02, 0.02, 1.0),
    };
    let texels = (0..width * height)
        .map(|i| match (i % width, i / width) {
            (column, row) if row < height / 2 => bar(column),
            (column, row) if row + 2 < height => 0.4 * bar(width - 1 - column),
            (column, _) if (9..11).contains(&column) => Vec3::splat(2.0),
            _ => Vec3::ZERO,
        })
        .collect();
    Texture::new(width, height, texels).expect("numbers of this program")
}
