//! A ball in coloured light.

use glam::{Vec2, Vec3};

use super::primitives::{cuboid, icosphere};
use super::random::Random;
use super::stage::{Stage, aim, fog, look, paint, upright};
use crate::{Cone, Light, PhaseFunction, Scene, SpotLight, Texture};

/// Texels along each side of the cookie.
const COOKIE: u32 = 64;

pub(super) fn build(mut stage: Stage, seed: u64) -> Scene {
    let ball = stage.shape("ball", icosphere(5), paint(0.8, 0.8, 0.8));
    stage.place(ball, upright(Vec3::ONE, 0.0, Vec3::new(0.0, 1.3, 0.0)));
    let floor = cuboid(Vec3::new(-12.0, -0.3, -12.0), Vec3::new(12.0, 0.0, 12.0));
    stage.add("floor", floor, paint(0.6, 0.6, 0.6));

    let position = Vec3::new(-3.6, 6.4, -1.6);
    let spot = SpotLight {
        position,
        rotation: aim(position, Vec3::new(0.0, 1.0, 0.0)),
        intensity: Vec3::splat(1500.0),
        range: f32::INFINITY,
        cone: Cone {
            inner: 0.40,
            outer: 0.44,
        },
        texture: Some(window(seed)),
        ..SpotLight::default()
    };
    stage.seen(
        look(Vec3::new(2.4, 3.8, 8.8), Vec3::new(0.0, 2.2, 0.0), 46.0),
        vec![Light::Spot(spot)],
        fog(
            Vec3::splat(0.05),
            Vec3::splat(0.004),
            PhaseFunction::Isotropic,
        ),
    )
}

/// A rose window: panes around random sites, folded into one eighth of the
/// square so that the pattern is symmetric, with dark leads between them that
/// are wide enough for the cookie to be smooth.
fn window(seed: u64) -> Texture {
    const GLASS: [Vec3; 6] = [
        Vec3::new(1.0, 0.10, 0.06),
        Vec3::new(0.08, 0.20, 1.0),
        Vec3::new(1.0, 0.62, 0.08),
        Vec3::new(0.10, 0.85, 0.25),
        Vec3::new(0.65, 0.12, 0.95),
        Vec3::new(0.15, 0.80, 0.95),
    ];
    let mut random = Random::new(seed);
    // The pane in the middle is a site on the axis of symmetry.
    let mut sites = vec![(Vec2::ZERO, GLASS[random.below(6) as usize])];
    for _ in 0..300 {
        let site = Vec2::new(random.between(0.2, 1.0), random.between(0.0, 1.0));
        let apart = |&(other, _): &(Vec2, Vec3)| site.distance(other) > 0.15;
        // Below the diagonal, and not so close that a pane is all lead.
        if site.y <= site.x && sites.iter().all(apart) {
            sites.push((site, GLASS[sites.len() % GLASS.len()]));
        }
    }
    let texel = |index: u32| {
        let (x, y) = (index % COOKIE, index / COOKIE);
        let centre = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let p = (2.0 * centre / COOKIE as f32 - 1.0).abs();
        let p = if p.y > p.x { Vec2::new(p.y, p.x) } else { p };
        let (mut nearest, mut second, mut colour) = (f32::INFINITY, f32::INFINITY, Vec3::ZERO);
        for &(site, glass) in &sites {
            let distance = p.distance(site);
            if distance < nearest {
                (second, nearest, colour) = (nearest, distance, glass);
            } else {
                second = second.min(distance);
            }
        }
        let lead = ((second - nearest) / 0.05).min(1.0);
        colour * (lead * lead * (3.0 - 2.0 * lead))
    };
    Texture::new(COOKIE, COOKIE, (0..COOKIE * COOKIE).map(texel).collect())
        .expect("numbers of this program")
}
