//! Exact visibility on both backends.

use glam::Vec3;
use gpu_backend::gpu::{Gpu, Queued};
use gpu_backend::{Cpu, assert_same_layout, testing};
use reference::tolerances::Allowed;

use super::agreement::{allowed, gathered, without_borders};
use super::complete;
use super::scenes::{casters, lights, masked_casters, media, rays};
use crate::airlight::{EquiAngular, Midpoint};
use crate::methods::exact::gpu::ExactRecord;
use crate::methods::exact::{UploadTracerError, UploadedTracer};
use crate::scene::trace::{PreorderNode, Tracer};
use crate::scene::{Emission, Geometry, Medium, Mesh, Scene};
use crate::visibility::{Exact, Unshadowed};
use crate::{Emitter, Ray};

#[test]
fn shaders_see_the_hierarchy_as_it_is() {
    let shader = complete::<UploadedTracer, Midpoint>();
    assert_same_layout!(
        shader,
        "light_Exact",
        ExactRecord {
            nodes,
            padding_a,
            padding_b,
            padding_c
        }
    );
    assert_same_layout!(
        shader,
        "light_exact_Node",
        PreorderNode {
            low,
            link,
            high,
            count
        }
    );
}

/// Triangles on both backends.
struct Both {
    here: Tracer,
    there: UploadedTracer,
    cpu: Cpu,
    gpu: Gpu<Queued>,
}

impl Both {
    /// `None` without a GPU.
    fn new(geometry: &Geometry) -> Option<Self> {
        let gpu = testing::gpu()?;
        let here = Tracer::new(geometry);
        Some(Self {
            there: UploadedTracer::new(&gpu, &here).unwrap(),
            here,
            cpu: Cpu::new(),
            gpu,
        })
    }

    fn of(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Option<Self> {
        let scene = Scene::from(Mesh {
            positions,
            triangles,
            ..Mesh::default()
        });
        Self::new(&Geometry::new(&scene).unwrap())
    }

    /// The rays that differ by more than is allowed.
    fn differing(&self, rays: &[Ray], light: &Emitter, medium: &Medium) -> Vec<usize> {
        let airlight = &EquiAngular::new(8).unwrap();
        let everywhere = without_borders(light);
        let scale = gathered(
            &self.cpu,
            rays,
            &everywhere,
            medium,
            (&Unshadowed, airlight),
        );
        let exact = &Exact::new(&self.here);
        let expected = gathered(&self.cpu, rays, light, medium, (exact, airlight));
        let actual = gathered(&self.gpu, rays, light, medium, (&self.there, airlight));
        let differs = |i: &usize| {
            (0..3).any(|c| {
                let (e, g) = (expected[*i][c], actual[*i][c]);
                let scale = scale[*i][c].max(e).max(f32::MIN_POSITIVE);
                let differs = !((e - g).abs() <= scale * allowed(&rays[*i], light));
                if differs {
                    let off = (e - g).abs() / scale;
                    println!("{e} {g}: {off}, {} allowed", allowed(&rays[*i], light));
                }
                differs
            })
        };
        (0..rays.len()).filter(differs).collect()
    }
}

#[test]
fn all_lights_and_media_agree_but_for_few_rays() {
    let Some(both) = Both::new(&casters()) else {
        return;
    };
    let rays = rays(3000, 1e-3);
    let (mut all, mut different) = (0, 0);
    for (name, light) in lights() {
        for (medium_name, medium) in media() {
            let differing = both.differing(&rays, &light, &medium);
            println!("{name}, {medium_name}: {} rays differ", differing.len());
            all += rays.len();
            different += differing.len();
        }
    }
    let share = different as f64 / all as f64;
    println!("{share:.6} of rays differ");
    assert!(share <= Allowed::GpuExactRays.error(), "{share}");
}

fn lamp(position: Vec3) -> Emitter {
    Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap()
}

fn fog() -> Medium {
    media().swap_remove(0).1
}

/// More dark intervals than a shader keeps at once.
#[test]
fn shadows_of_a_hundred_slats_agree() {
    let mut positions = Vec::new();
    for slat in 0..100 {
        let x = 0.2 * (slat as f32 - 50.0);
        for (x, z) in [(x, -3.0), (x + 0.1, -3.0), (x + 0.1, 3.0), (x, 3.0)] {
            positions.push(Vec3::new(x, 1.0, z));
        }
    }
    let triangles = (0..100).flat_map(|slat| {
        let first = 4 * slat;
        [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    });
    let Some(both) = Both::of(positions, triangles.collect()) else {
        return;
    };
    let rays: Vec<Ray> = (0..64)
        .map(|i| {
            let direction = Vec3::new(1.0, 0.004 * (i % 8) as f32, 0.02 * (i / 8) as f32);
            Ray::new(Vec3::new(-12.0, -0.3, 0.0), direction, 30.0).unwrap()
        })
        .collect();
    let sun = Emitter::directional(Vec3::new(0.2, -1.0, 0.1), Vec3::ONE).unwrap();
    for light in [lamp(Vec3::new(0.5, 3.0, 0.2)), sun] {
        let differing = both.differing(&rays, &light, &fog());
        assert!(differing.is_empty(), "{differing:?}");
    }
}

/// Lamps where three walls meet, on an edge, on a wall, before it, behind it and in its plane;
/// eyes on a wall and at the lamp. Rays at a lamp, away from it and from it are left out where it
/// is on a wall: rounding decides on which side they pass it.
#[test]
fn lights_and_eyes_in_the_planes_of_walls_agree() {
    let corner = Vec3::new(3.0, -1.5, -4.0);
    let (x, y, z) = (-6.0 * Vec3::X, 4.0 * Vec3::Y, 5.0 * Vec3::Z);
    let positions = vec![
        corner,
        corner + x,
        corner + x + y,
        corner + y,
        corner + z,
        corner + x + z,
    ];
    let triangles = vec![[0, 2, 1], [0, 3, 2], [0, 5, 4], [0, 1, 5]];
    let Some(both) = Both::of(positions, triangles) else {
        return;
    };
    let centre = corner + 0.5 * (x + y);
    for (lamp_at, is_on_wall) in [
        (corner, true),
        (corner + 0.5 * x, true),
        (centre, true),
        (centre + 0.5 * z, false),
        (centre - 0.5 * z, false),
        (corner + y + 0.3 * x + 2.0 * Vec3::Y, false),
    ] {
        let mut rays = Vec::new();
        for eye in [
            Vec3::new(-0.3, 0.4, 2.5),
            centre,
            centre - z,
            lamp_at + 2.0 * z,
            lamp_at,
        ] {
            if is_on_wall && eye == lamp_at {
                continue;
            }
            for step in 0..50 {
                let turn = 0.05 * (step - 25) as f32;
                let direction = Vec3::new(turn, 0.3 * turn + 0.01, -1.0);
                rays.push(Ray::new(eye, direction, 5.0).unwrap());
            }
            if is_on_wall || eye == lamp_at {
                continue;
            }
            for towards in [lamp_at - eye, eye - lamp_at] {
                rays.push(Ray::new(eye, towards, f32::INFINITY).unwrap());
            }
        }
        let differing = both.differing(&rays, &lamp(lamp_at), &fog());
        let differing: Vec<_> = differing.iter().map(|ray| rays[*ray]).collect();
        assert!(differing.is_empty(), "{lamp_at}: {differing:?}");
    }
    for sun in [Vec3::NEG_Y, Vec3::Z, Vec3::new(-0.3, -1.0, 0.2)] {
        let directions = [sun, -sun, Vec3::new(0.1, -0.2, -1.0)];
        let rays = directions.map(|direction| {
            Ray::new(Vec3::new(-0.3, 0.4, -2.5), direction, f32::INFINITY).unwrap()
        });
        let sun = Emitter::directional(sun, Vec3::ONE).unwrap();
        let differing = both.differing(&rays, &sun, &fog());
        assert!(differing.is_empty(), "{differing:?}");
    }
}

#[test]
fn lamps_far_beyond_all_triangles_agree() {
    let Some(both) = Both::new(&casters()) else {
        return;
    };
    let rays = rays(1000, 0.05);
    for distance in [30.0, 1e3, 1e5] {
        for way in [Vec3::new(0.3, 1.0, 0.2), Vec3::new(-1.0, 0.1, 0.4)] {
            let differing = both.differing(&rays, &lamp(distance * way), &fog());
            let share = differing.len() as f64 / rays.len() as f64;
            assert!(
                share <= Allowed::GpuExactRays.error(),
                "{distance}: {share}"
            );
        }
    }
}

#[test]
fn triangles_that_cast_no_shadow_leave_all_lit() {
    let corners = [Vec3::ZERO, 9.0 * Vec3::X, 9.0 * Vec3::Z];
    let mut scene = Scene::from(Mesh {
        name: "floor".into(),
        positions: corners.into(),
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    });
    scene.set_casts_shadow("floor", false);
    let Some(both) = Both::new(&Geometry::new(&scene).unwrap()) else {
        return;
    };
    let rays = rays(100, 0.1);
    let airlight = &EquiAngular::new(2).unwrap();
    for (_, light) in lights() {
        let found = gathered(&both.gpu, &rays, &light, &fog(), (&both.there, airlight));
        let lit = gathered(&both.gpu, &rays, &light, &fog(), (&Unshadowed, airlight));
        assert_eq!(found, lit);
    }
}

#[test]
fn triangles_that_are_not_solid_are_refused_by_number() {
    let Some(gpu) = testing::gpu() else { return };
    let tracer = Tracer::new(&masked_casters());
    let error = UploadedTracer::new(&gpu, &tracer).unwrap_err();
    assert_eq!(error, UploadTracerError::NotSolid { triangle: 0 });
    assert!(error.to_string().contains("triangle 0"), "{error}");
}
