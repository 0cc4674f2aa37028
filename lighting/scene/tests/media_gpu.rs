//! Optical depths in shaders against those of the CPU.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

use glam::{Affine3A, Quat, Vec3};
use gpu_backend::gpu::{Argument, INDEX_WGSL, Kernel, Workgroups};
use gpu_backend::{Backend, Download, testing};
use reference::random::Random;
use scene::gpu::{GridRecord, HeightFogRecord, MEDIA};
use scene::{
    Bounds, DensityGrid, HeightFog, Interpolation, Media, Particle, Particles, PhaseFunction,
    Profile, Translucent,
};

/// A part of a line.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Line {
    origin: Vec3,
    near: f32,
    direction: Vec3,
    far: f32,
}

const DATA: &str = "
    struct Line { origin: vec3<f32>, near: f32, direction: vec3<f32>, far: f32 }
    struct Counts { lines: u32, padding_a: u32, padding_b: u32, padding_c: u32 }
    @group(0) @binding(0) var<uniform> counts: Counts;
    @group(0) @binding(1) var<storage> lines: array<Line>;
    @group(0) @binding(2) var<storage, read_write> depths: array<f32>;";

const GRID: &str = "
    @group(0) @binding(3) var<uniform> grid: scn_Grid;
    @group(0) @binding(4) var<storage> densities: array<f32>;
    fn scn_density(index: u32) -> f32 { return densities[index]; }
    fn depth(line: Line) -> f32 {
        return scn_grid_depth(grid, line.origin, line.direction, line.near, line.far);
    }";

/// By the cubic at both halves of each span, which must not change the sum.
const HALVES: &str = "
    @group(0) @binding(3) var<uniform> grid: scn_Grid;
    @group(0) @binding(4) var<storage> densities: array<f32>;
    fn scn_density(index: u32) -> f32 { return densities[index]; }
    fn depth(line: Line) -> f32 {
        var sum = 0.0;
        var walk = scn_walk(grid, line.origin, line.direction, line.near, line.far);
        while scn_next_cell(&walk) {
            let length = walk.far - walk.near;
            let middle = walk.near + 0.25 * length;
            let whole = scn_cubic(grid, walk, walk.near, walk.far);
            sum += 0.25 * length * scn_mean(scn_up_to(whole, 0.25));
            sum += (walk.far - middle) * scn_mean(scn_cubic(grid, walk, middle, walk.far));
        }
        return sum;
    }";

const HEIGHT: &str = "
    @group(0) @binding(3) var<uniform> fog: scn_HeightFog;
    fn scn_density(index: u32) -> f32 { return 0.0; }
    fn depth(line: Line) -> f32 {
        let y = line.origin.y + line.near * line.direction.y;
        let length = select(line.far - line.near, scn_FAR, line.far == scn_FAR);
        return scn_height_column(fog, y, line.direction.y, length);
    }";

const BALL: &str = "
    @group(0) @binding(3) var<uniform> ball: vec4<f32>;
    fn scn_density(index: u32) -> f32 { return 0.0; }
    fn depth(line: Line) -> f32 {
        let chord = scn_chord(ball.xyz, ball.w, line.origin, line.direction);
        let near = max(line.near, chord.x - chord.y);
        let far = min(line.far, chord.x + chord.y);
        if near >= far { return 0.0; }
        let cubic = scn_ball_cubic(0.7, ball.w, true, chord, near, far);
        return (far - near) * scn_mean(cubic);
    }";

const ENTRY: &str = "
    @compute @workgroup_size(64)
    fn measure(
        @builtin(workgroup_id) workgroup: vec3<u32>,
        @builtin(num_workgroups) workgroups: vec3<u32>,
        @builtin(local_invocation_index) local: u32,
    ) {
        let i = gpu_index(workgroup, workgroups, local, 64u);
        if i < counts.lines { depths[i] = depth(lines[i]); }
    }";

fn measured(
    gpu: &gpu_backend::gpu::Gpu<gpu_backend::gpu::Queued>,
    what: &'static str,
    lines: &[Line],
    arguments: Vec<Argument<'_>>,
) -> Vec<f32> {
    let buffer = gpu.upload(lines).unwrap();
    let mut depths = gpu.zeros::<f32>(lines.len()).unwrap();
    let mut all = vec![
        Argument::uniform([lines.len() as u32, 0, 0, 0]),
        Argument::read(&buffer),
        Argument::write(&mut depths),
    ];
    all.extend(arguments);
    gpu.dispatch(
        &Kernel {
            label: "measure",
            parts: &[INDEX_WGSL, MEDIA, DATA, what, ENTRY],
            entry: "measure",
            constants: &[],
        },
        &[&all],
        Workgroups::covering(lines.len(), 64),
    )
    .unwrap();
    gpu.download(&depths).unwrap()
}

fn point(random: &mut Random, size: f32) -> Vec3 {
    Vec3::from_array([(); 3].map(|()| random.between(-size, size)))
}

/// Lines towards points near the origin from anywhere within `size`, a few of them along
/// axes.
fn lines(random: &mut Random, size: f32) -> Vec<Line> {
    (0..2000)
        .map(|i| {
            let origin = point(random, size);
            let direction = match i % 10 {
                0 => Vec3::AXES[random.below(3) as usize],
                _ => (point(random, 1.5) - origin).normalize(),
            };
            let near = random.between(0.0, size);
            let far = match i % 3 {
                0 => f32::MAX,
                _ => near + random.between(0.0, 2.0 * size),
            };
            Line {
                origin,
                near,
                direction,
                far,
            }
        })
        .collect()
}

fn on_the_cpu(casters: &[Translucent], line: &Line) -> f64 {
    let media = Media::new(None, None, casters);
    let (origin, direction) = (line.origin.as_dvec3(), line.direction.as_dvec3());
    media
        .optical_depth(origin, direction, line.near.into(), line.far.into())
        .x
}

#[test]
fn depths_through_grids_are_those_of_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let mut random = Random::new(1);
    for (round, size) in [(0, 1.0_f32), (1, 4.0), (2, 4.0), (3, 100.0), (4, 2.0)] {
        let resolution = [[5, 4, 6], [1, 1, 1], [9, 2, 1], [16, 16, 16], [3, 3, 3]][round];
        let interpolation = [Interpolation::Linear, Interpolation::Constant][round / 4];
        // From 1, so that the digits of a point moved aside are those of the sum.
        let count = resolution.iter().product::<u32>();
        let density: Vec<f32> = (0..count).map(|_| 1.0 + random.unit()).collect();
        let bounds = Bounds::new(Vec3::new(-1.0, -0.8, -1.2), Vec3::new(1.0, 1.1, 0.9)).unwrap();
        let turn = Quat::from_rotation_y(0.3 * round as f32);
        let grid = DensityGrid::new(bounds, resolution, density.clone(), 3.0, interpolation)
            .unwrap()
            .with_transform(Affine3A::from_quat(turn))
            .unwrap();
        let lines = lines(&mut random, size);
        let densities = gpu.upload(&[&[9.0], &density[..]].concat()).unwrap();
        let record = GridRecord::new(&grid, 1);
        let arguments = || vec![Argument::uniform(record), Argument::read(&densities)];
        let found = measured(&gpu, GRID, &lines, arguments());
        let halves = measured(&gpu, HALVES, &lines, arguments());
        let casters = [grid.into()];
        let mut compared = 0;
        for ((line, found), halves) in lines.iter().zip(found).zip(halves) {
            let expected = on_the_cpu(&casters, line);
            // Moved aside by this much, a line is longer or shorter by up to 50 times as
            // much in the box and at most 6 denser; a grazing one may miss.
            let aside = f64::from(f32::EPSILON) * 2.0 * f64::from(size + 3.0);
            let allowed = 60.0 * 6.0 * aside + 70.0 * f64::from(f32::EPSILON) * expected;
            let error = (f64::from(found) - expected).abs();
            assert!(error <= allowed, "{round} {line:?}: {found} for {expected}");
            assert!((found - halves).abs() <= 1e-5 * found, "{found} {halves}");
            compared += usize::from(expected > 0.1);
        }
        assert!(compared > 300, "{round}: {compared}");
    }
}

#[test]
fn columns_of_height_fog_are_those_of_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let mut random = Random::new(2);
    for scale_height in [0.2, 3.0, 1e4] {
        let phase = PhaseFunction::Isotropic;
        let fog = HeightFog::new(Vec3::ONE, Vec3::ONE, 0.3, scale_height, phase).unwrap();
        let lines = lines(&mut random, 4.0);
        let record = HeightFogRecord::from(&fog);
        let found = measured(&gpu, HEIGHT, &lines, vec![Argument::uniform(record)]);
        for (line, found) in lines.iter().zip(found) {
            let slope = f64::from(line.direction.y);
            let y = f64::from(line.origin.y) + f64::from(line.near) * slope;
            if line.far == f32::MAX && slope <= 1e-3 {
                // Endless, or as good as.
                assert!(found > 1e3 && found <= f32::MAX, "{line:?} {found}");
                continue;
            }
            let length = match line.far {
                f32::MAX => f64::INFINITY,
                far => f64::from(far - line.near),
            };
            let expected = fog.column(y, slope, length);
            // The exponent has a rounding of the height, which is within 20, over the
            // scale height, and is taken to 3 + 2 |x| units.
            let height = 20.0 / f64::from(scale_height);
            let allowed = f64::from(f32::EPSILON) * (20.0 + 6.0 * height);
            let error = (f64::from(found) / expected - 1.0).abs();
            // e^-80 is where shaders stop.
            if expected > 1e-30 {
                assert!(error <= allowed, "{line:?}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn depths_through_balls_are_those_of_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let mut random = Random::new(3);
    let lines = lines(&mut random, 4.0);
    let ball = Particle {
        centre: Vec3::new(0.2, -0.1, 0.3),
        radius: 1.3,
        sigma_t: 0.7,
    };
    let record = ball.centre.extend(ball.radius);
    let found = measured(&gpu, BALL, &lines, vec![Argument::uniform(record)]);
    let casters = [Particles::new(vec![ball], Profile::Soft).unwrap().into()];
    for (line, found) in lines.iter().zip(found) {
        let expected = on_the_cpu(&casters, line);
        // Half a chord is the root of what is left of 1.3².
        let error = (f64::from(found) - expected).abs();
        assert!(
            error <= 1e-5 * (1.0 + expected),
            "{line:?}: {found} for {expected}"
        );
    }
}
