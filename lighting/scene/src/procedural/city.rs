//! Streets, buildings and trees.

use glam::{Affine3A, Vec3};

use super::primitives::{cuboid, frustum, icosphere};
use super::random::Random;
use super::stage::{Shape, Stage, fog, look, paint, upright};
use crate::{DirectionalLight, Light, PhaseFunction, Scene};

/// Blocks along each side of the city; even, so that a street runs through
/// its centre.
const BLOCKS: u32 = 18;
/// Distance between the centres of two blocks, m.
const PITCH: f32 = 46.0;
/// Half the width of a block, m; the rest of the pitch is street.
const HALF_BLOCK: f32 = 15.0;
/// Radius of a lamp post, m. The light map of the whole city at 2048 texels
/// a side has texels of about half a metre.
const POLE_RADIUS: f32 = 0.07;
/// The eye stands at the edge of the park, m.
const EYE: Vec3 = Vec3::new(-3.0, 6.0, 95.0);

/// Each block has four buildings with two or three boxes on their roofs,
/// eight trees of a trunk and a crown, and four lamp posts: at least 32
/// solids. Eight blocks in the middle are a park of trees, with towers behind
/// it. Roof boxes are sunk into the roofs, trunks end inside the crowns,
/// and everything stands a little in the ground.
pub(super) fn build(mut stage: Stage, seed: u64) -> Scene {
    streets(&mut stage, seed);
    seen(stage, sun())
}

/// The same with traffic that moves.
pub(super) fn with_traffic(mut stage: Stage, seed: u64) -> Scene {
    streets(&mut stage, seed);
    traffic(&mut stage, seed);
    seen(stage, sun())
}

fn sun() -> Light {
    Light::Directional(DirectionalLight {
        direction: Vec3::new(0.255, -0.37, 1.0),
        irradiance: Vec3::new(2.3, 1.95, 1.5),
        ..DirectionalLight::default()
    })
}

/// Cars on both lanes of the streets through the park, a body and a cabin each, and
/// three balloons between the towers and the eye.
fn traffic(stage: &mut Stage, seed: u64) {
    let mut random = Random::new(seed ^ 0x7261_6666_6963);
    let unit_box = || cuboid(Vec3::new(-0.5, 0.0, -0.5), Vec3::new(0.5, 1.0, 0.5));
    let body = stage.shape("car", unit_box(), paint(0.60, 0.12, 0.10));
    let cabin = stage.shape("cabin", unit_box(), paint(0.15, 0.17, 0.20));
    let balloon = stage.shape("balloon", icosphere(3), paint(0.75, 0.55, 0.15));
    for (turns, along, aside) in [(0.25, Vec3::X, Vec3::Z), (0.0, Vec3::Z, Vec3::X)] {
        for street in [0.0, 1.0] {
            for lane in [-2.2, 2.2] {
                for place in 0..6 {
                    let at = 14.0 * place as f32 - 42.0 + random.between(-4.0, 4.0);
                    let foot =
                        at * along + (PITCH * street + lane) * aside + 46.0 * Vec3::Z * along.z;
                    let length = random.between(4.0, 6.5);
                    let low = Vec3::new(1.8, 1.0, length);
                    stage.place_dynamic(body, upright(low, turns, foot + 0.3 * Vec3::Y));
                    let high = Vec3::new(1.6, random.between(0.7, 1.6), 0.6 * length);
                    stage.place_dynamic(cabin, upright(high, turns, foot + 1.2 * Vec3::Y));
                }
            }
        }
    }
    for place in [-1.0, 0.0, 1.0] {
        let shift = Vec3::new(random.between(-4.0, 4.0), random.between(-5.0, 5.0), 0.0);
        let centre = Vec3::new(24.0 * place - 8.0, 44.0, 30.0 - 12.0 * place) + shift;
        let radius = random.between(4.0, 5.5);
        stage.place_dynamic(balloon, upright(Vec3::splat(radius), 0.0, centre));
    }
}

/// The same by night, with a glowing rectangle high above the park, behind the top
/// of the picture.
pub(super) fn under_a_panel(mut stage: Stage, seed: u64) -> Scene {
    streets(&mut stage, seed);
    let radiance = Vec3::new(2100.0, 2000.0, 1800.0);
    let panel = stage.panel(Vec3::new(-26.0, 95.0, 20.0), [40.0, 26.0], radiance);
    seen(stage, Light::Area(panel))
}

fn streets(stage: &mut Stage, seed: u64) {
    let mut random = Random::new(seed);
    let unit_box = || cuboid(Vec3::new(-0.5, 0.0, -0.5), Vec3::new(0.5, 1.0, 0.5));
    let walls = [
        paint(0.55, 0.45, 0.38),
        paint(0.60, 0.58, 0.55),
        paint(0.48, 0.34, 0.28),
        paint(0.42, 0.46, 0.52),
    ]
    .map(|material| stage.shape("building", unit_box(), material));
    let props = Props {
        walls,
        roof: stage.shape("roof box", unit_box(), paint(0.40, 0.40, 0.42)),
        trunk: stage.shape(
            "trunk",
            frustum(5, 0.22, 0.14, 1.0),
            paint(0.25, 0.18, 0.12),
        ),
        crown: stage.shape("crown", icosphere(1), paint(0.22, 0.36, 0.14)),
        pole: stage.shape(
            "pole",
            frustum(5, POLE_RADIUS, POLE_RADIUS, 1.0),
            paint(0.3, 0.3, 0.3),
        ),
    };

    let half = 0.5 * PITCH * BLOCKS as f32 + 10.0;
    let ground = cuboid(Vec3::new(-half, -1.0, -half), Vec3::new(half, 0.0, half));
    stage.add("ground", ground, paint(0.45, 0.44, 0.42));
    for row in 0..BLOCKS {
        for column in 0..BLOCKS {
            let centre = |index: u32| PITCH * (index as f32 + 0.5 - 0.5 * BLOCKS as f32);
            let block = Vec3::new(centre(column), 0.0, centre(row));
            let middle = (7..=10).contains(&column);
            if middle && (9..=10).contains(&row) {
                props.park(stage, &mut random, block);
            } else {
                let towers = if middle && row < 9 { 0.45 } else { 0.15 };
                props.block(stage, &mut random, block, towers);
            }
        }
    }
}

fn seen(stage: Stage, light: Light) -> Scene {
    let phase = PhaseFunction::HenyeyGreenstein { g: 0.6 };
    stage.seen(
        look(EYE, Vec3::new(-6.0, 22.0, 0.0), 52.0),
        vec![light],
        fog(
            Vec3::new(0.0060, 0.0064, 0.0070),
            Vec3::splat(0.0004),
            phase,
        ),
    )
}

/// What a block is made of.
#[derive(Debug)]
struct Props {
    walls: [Shape; 4],
    roof: Shape,
    trunk: Shape,
    crown: Shape,
    pole: Shape,
}

impl Props {
    fn block(&self, stage: &mut Stage, random: &mut Random, block: Vec3, towers: f32) {
        for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let lot = block + 0.5 * HALF_BLOCK * Vec3::new(x, 0.0, z);
            self.building(stage, random, lot, towers);
            let corner = block + (HALF_BLOCK + 3.0) * Vec3::new(x, 0.0, z);
            let height = random.between(7.0, 9.0);
            let pole = upright(
                Vec3::new(1.0, height + 0.5, 1.0),
                0.0,
                corner - 0.5 * Vec3::Y,
            );
            stage.place(self.pole, pole);
        }
        // Two trees in front of each side of the block.
        for (out, along) in [(Vec3::X, Vec3::Z), (Vec3::Z, Vec3::X)] {
            for side in [-1.0, 1.0] {
                for place in [-8.0, 8.0] {
                    let shift = place + random.between(-3.0, 3.0);
                    let foot = block + side * (HALF_BLOCK + 2.0) * out + shift * along;
                    self.tree(stage, random, foot);
                }
            }
        }
    }

    /// Up to sixteen trees in two rows, none right in front of the eye.
    fn park(&self, stage: &mut Stage, random: &mut Random, block: Vec3) {
        for i in 0..16 {
            let (row, place) = ((i / 8) as f32, (i % 8) as f32);
            let shift = Vec3::new(random.between(-2.0, 2.0), 0.0, random.between(-1.5, 1.5));
            let foot = Vec3::new(5.5 * place - 19.0, 0.0, 24.0 * row - 12.0);
            let foot = block + foot + shift;
            if foot.distance(EYE) > 34.0 {
                self.tree(stage, random, foot);
            }
        }
    }

    fn building(&self, stage: &mut Stage, random: &mut Random, lot: Vec3, towers: f32) {
        let tower = random.unit() < towers;
        let height = if tower {
            random.between(38.0, 70.0)
        } else {
            random.between(9.0, 32.0)
        };
        let width = random.between(9.5, 13.5);
        let depth = random.between(9.5, 13.5);
        let walls = self.walls[random.below(4) as usize];
        let body = Affine3A::from_scale_rotation_translation(
            Vec3::new(width, height + 0.5, depth),
            glam::Quat::IDENTITY,
            lot - 0.5 * Vec3::Y,
        );
        stage.place(walls, body);
        for _ in 0..2 + random.below(2) {
            let size = Vec3::new(
                random.between(1.5, 4.0),
                random.between(1.5, 4.5),
                random.between(1.5, 4.0),
            );
            let reach = 0.5 * Vec3::new(width, 0.0, depth) - 0.5 * size.with_y(0.0);
            let offset = Vec3::new(random.between(-1.0, 1.0), 0.0, random.between(-1.0, 1.0));
            let foot = lot + offset * reach + (height - 0.5) * Vec3::Y;
            stage.place(self.roof, upright(size, 0.0, foot));
        }
    }

    fn tree(&self, stage: &mut Stage, random: &mut Random, foot: Vec3) {
        let height = random.between(2.6, 4.5);
        let radius = random.between(1.3, 2.1);
        let turns = random.unit();
        let trunk = Vec3::new(1.0, height + 0.3, 1.0);
        stage.place(self.trunk, upright(trunk, turns, foot - 0.3 * Vec3::Y));
        let crown = radius * Vec3::new(1.0, random.between(1.0, 1.5), 1.0);
        let centre = foot + (height + 0.7 * crown.y) * Vec3::Y;
        stage.place(self.crown, upright(crown, turns, centre));
    }
}
