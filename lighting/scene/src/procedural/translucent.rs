//! Smoke and hair that let a part of the light through.

use glam::{Vec2, Vec3};

use super::primitives::{cuboid, icosphere};
use super::random::{Random, circle, value_noise};
use super::smoke::smoke_puffs;
use super::stage::{Stage, aim, fog, look, paint, upright};
use crate::{
    Bounds, Cone, DensityGrid, Interpolation, Light, Particle, Particles, PhaseFunction, Profile,
    Scene, SceneError, SpotLight, StrandPoint, Strands, Translucent,
};

/// Points of each strand of a [`ponytail`].
pub(super) const POINTS: u32 = 16;

/// As many as [`Strands`] may have points for.
const MAX_STRANDS: u32 = (1 << 26) / POINTS;

/// The columns of [`smoke_puffs`] as soft balls; at their centres they are as
/// dense as a puff is all over.
pub fn smoke_particles(seed: u64) -> Particles {
    let particle = |puff: super::Puff| Particle {
        centre: puff.centre,
        radius: puff.radius,
        sigma_t: puff.sigma_t,
    };
    let all = smoke_puffs(seed).into_iter().map(particle).collect();
    Particles::new(all, Profile::Soft).expect("numbers of this program")
}

/// A billowing cloud in the unit box on 48 × 64 × 48 samples, of extinction up
/// to `sigma_t` 1/m: noise of four octaves over a plume that widens upwards.
///
/// # Errors
/// [`SceneError::BadValue`] unless `sigma_t` is from 0 to 1e15.
pub fn smoke_grid(seed: u64, sigma_t: f32) -> Result<DensityGrid, SceneError> {
    const RESOLUTION: [u32; 3] = [48, 64, 48];
    let mut density = Vec::with_capacity(RESOLUTION.iter().product::<u32>() as usize);
    for z in 0..RESOLUTION[2] {
        for y in 0..RESOLUTION[1] {
            for x in 0..RESOLUTION[0] {
                let share = |index: u32, axis: usize| index as f32 / (RESOLUTION[axis] - 1) as f32;
                let at = Vec3::new(share(x, 0), share(y, 1), share(z, 2));
                density.push(billow(seed, at));
            }
        }
    }
    let bounds = Bounds::new(Vec3::ZERO, Vec3::ONE).expect("numbers of this program");
    DensityGrid::new(bounds, RESOLUTION, density, sigma_t, Interpolation::Linear)
}

/// From 0 to 1; 0 on the faces of the unit box.
fn billow(seed: u64, at: Vec3) -> f32 {
    let (mut noise, mut frequency, mut weight) = (0.0, 4.0, 0.5);
    for octave in 0..4 {
        // Noise of the plane, sheared along the third axis, twice.
        let a = Vec2::new(at.x + 0.7 * at.z, at.y - 0.4 * at.z) * frequency;
        let b = Vec2::new(at.z - 0.5 * at.x, at.y + 0.6 * at.x) * frequency;
        let seed = seed.wrapping_add(1000 * octave);
        noise += weight * (value_noise(seed, a) + value_noise(seed ^ 0x5bd1, b) - 1.0);
        (frequency, weight) = (2.0 * frequency, 0.5 * weight);
    }
    let sway = 0.08 * circle(1.3 * at.y).x;
    let across = Vec2::new(at.x - 0.5 - sway, at.z - 0.5).length() / (0.16 + 0.26 * at.y);
    let body = 1.0 - across * across + 1.4 * noise;
    let ends = (8.0 * at.y.min(1.0 - at.y)).min(1.0);
    let sides = (8.0 * (0.5 - (at.x - 0.5).abs().max((at.z - 0.5).abs()))).min(1.0);
    (body * ends * sides).clamp(0.0, 1.0)
}

/// A ponytail of about 1 m that hangs from the origin: `count` strands of 16
/// points in wisps, each of `thickness` metres and the given opacity, both
/// tapering off to half at the tips.
///
/// # Errors
/// [`SceneError::BadValue`] for more than 2²² strands, a thickness outside of 0
/// to 1e8 m, an opacity outside of 0 to 1.
pub fn ponytail(
    seed: u64,
    count: u32,
    thickness: f32,
    opacity: f32,
) -> Result<Strands, SceneError> {
    if count > MAX_STRANDS {
        return Err(SceneError::bad_value(
            "ponytail",
            "the number of strands",
            count,
            "at most 2^22",
        ));
    }
    let mut random = Random::new(seed);
    let wisps: Vec<(Vec3, f32)> = (0..40)
        .map(|_| (0.12 * random.in_ball(), random.unit()))
        .collect();
    let mut points = Vec::with_capacity((count * POINTS) as usize);
    for _ in 0..count {
        let (wisp, turn) = wisps[random.below(wisps.len() as u32) as usize];
        let root = 0.04 * random.in_ball();
        let within = 0.05 * random.in_ball();
        let reach = random.between(0.8, 1.1);
        let curl = random.between(0.6, 1.0);
        for i in 0..POINTS {
            let t = i as f32 / (POINTS - 1) as f32;
            // Out and up at the root, then down; wisps part towards the tips.
            let drop = Vec3::new(0.0, 0.25 * t - 1.15 * t * t, 0.55 * t - 0.25 * t * t);
            let wave = circle(turn + curl * t) * (0.05 * t);
            let position = root * (1.0 - 0.5 * t)
                + reach * drop
                + (wisp + within) * (2.2 * t).min(1.0)
                + Vec3::new(wave.x, 0.0, wave.y);
            let taper = 1.0 - 0.5 * t;
            points.push(StrandPoint {
                position,
                thickness: thickness * taper,
                opacity: opacity * taper,
            });
        }
    }
    let ends = (1..=count).map(|strand| strand * POINTS).collect();
    Strands::new(points, ends)
}

/// Three columns of soft puffs, a plume on a grid, and a ball with a ponytail in
/// front of it, against a spotlight that shines through all of them at the eye.
pub(super) fn build(mut stage: Stage, seed: u64) -> Scene {
    let floor = cuboid(Vec3::new(-14.0, -0.3, -12.0), Vec3::new(14.0, 0.0, 12.0));
    stage.add("floor", floor, paint(0.45, 0.45, 0.45));
    let ball = stage.shape("head", icosphere(3), paint(0.7, 0.5, 0.4));
    let head = Vec3::new(3.3, 1.9, -0.2);
    stage.place(ball, upright(Vec3::splat(0.55), 0.0, head));

    let hair = ponytail(seed, 1500, 0.006, 0.6).expect("numbers of this program");
    let moved = hair.points().iter().map(|point| StrandPoint {
        position: head + Vec3::new(0.0, 0.3, 0.45) + 1.4 * point.position,
        ..*point
    });
    let ends = (1..=hair.len() as u32).map(|strand| strand * POINTS);
    let hair = Strands::new(moved.collect(), ends.collect()).expect("numbers of this program");
    let plume = smoke_grid(seed, 3.0).expect("numbers of this program");
    let at = Bounds::new(Vec3::new(-5.2, 0.05, -1.2), Vec3::new(-3.2, 3.6, 0.8));
    let plume = DensityGrid::new(
        at.expect("numbers of this program"),
        plume.resolution(),
        plume.density().to_vec(),
        plume.scale(),
        plume.interpolation(),
    );
    let plume = plume.expect("densities that were fine before");
    let [particles, plume] = seen(smoke_particles(seed), plume).expect("numbers of this program");

    let position = Vec3::new(-0.5, 5.6, -7.0);
    let spot = SpotLight {
        position,
        rotation: aim(position, Vec3::new(0.0, 1.8, 0.0)),
        intensity: Vec3::new(420.0, 370.0, 300.0),
        range: f32::INFINITY,
        cone: Cone {
            inner: 0.6,
            outer: 0.8,
        },
        texture: None,
        ..SpotLight::default()
    };
    let mut scene = stage.seen(
        look(Vec3::new(0.6, 2.0, 10.0), Vec3::new(-0.3, 2.3, 0.0), 50.0),
        vec![Light::Spot(spot)],
        fog(
            Vec3::splat(0.045),
            Vec3::splat(0.005),
            PhaseFunction::HenyeyGreenstein { g: 0.4 },
        ),
    );
    scene.translucent = vec![particles, plume, hair.into()];
    scene
}

/// Smoke as it looks: nearly white puffs and a warmer plume that both scatter forwards.
fn seen(particles: Particles, plume: DensityGrid) -> Result<[Translucent; 2], SceneError> {
    let forwards = PhaseFunction::HenyeyGreenstein { g: 0.5 };
    let particles = particles
        .with_albedo(Vec3::splat(0.95))?
        .with_phase(forwards)?;
    let warm = Vec3::new(0.95, 0.88, 0.78);
    let plume = plume.with_albedo(warm)?.with_phase(forwards)?;
    Ok([particles.into(), plume.into()])
}
