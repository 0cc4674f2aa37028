//! Pictures from samples, of methods whose light is known.

use std::sync::Mutex;

use glam::Vec3;
use gpu_backend::{Cpu, Host};

use super::*;
use crate::methods::{
    About, Frame, FrameInputs, Method, MethodError, Role, RunOn, Selection, Store, Verdict,
};
use crate::scene::trace::{Hit, Tracer};
use crate::scene::view::View;
use crate::scene::{Camera, Geometry, Medium, Mesh, PhaseFunction, Scene};
use crate::{Interleaving, Ray};

/// A wall of 1.5 × 2 m on a floor, before the sky.
fn geometry() -> Geometry {
    let scene = Scene::from(Mesh {
        positions: vec![
            Vec3::new(-50.0, 0.0, -60.0),
            Vec3::new(50.0, 0.0, -60.0),
            Vec3::new(50.0, 0.0, 5.0),
            Vec3::new(-50.0, 0.0, 5.0),
            Vec3::new(0.1, 0.0, -5.0),
            Vec3::new(1.6, 0.0, -5.0),
            Vec3::new(1.6, 2.0, -5.0),
            Vec3::new(0.1, 2.0, -5.0),
        ],
        triangles: vec![[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]],
        ..Mesh::default()
    });
    Geometry::new(&scene).unwrap()
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.0, 1.2, 0.0), Vec3::new(0.0, 1.1, -5.0), 0.9).unwrap()
}

/// Calls `test` with a frame of rays, and what they end on.
fn with_rays<R>(
    size: [u32; 2],
    rays: &[Ray],
    hits: &[Option<Hit>],
    test: impl FnOnce(FrameInputs<'_>) -> R,
) -> R {
    let medium = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let (geometry, host) = (geometry(), Store::<Host>::new());
    test(FrameInputs {
        emitters: &[],
        areas: &[],
        medium: &medium,
        height_fog: None,
        geometry: &geometry,
        translucent: &[],
        camera: &camera(),
        size,
        rays,
        hits,
        map: 16,
        host: &host,
        selection: Selection::default(),
        watch: &(),
    })
}

/// The same with the view of the wall.
fn with_view<R>(size: [u32; 2], test: impl FnOnce(FrameInputs<'_>) -> R) -> R {
    let tracer = Tracer::new(&geometry());
    let view = View::new(&Cpu::new(), &camera(), &tracer, size[0], size[1]).unwrap();
    with_rays(size, view.rays(), view.hits(), test)
}

/// The same with rays of given lengths.
fn with_lengths<R>(
    size: [u32; 2],
    length: impl Fn(u32, u32) -> f32,
    test: impl FnOnce(FrameInputs<'_>) -> R,
) -> R {
    let rays: Vec<Ray> = (0..size[0] * size[1])
        .map(|i| {
            let (x, y) = (i % size[0], i / size[0]);
            let direction = camera().direction(x as f32 + 0.5, y as f32 + 0.5, size[0], size[1]);
            Ray::new(camera().eye(), direction, length(x, y)).unwrap()
        })
        .collect();
    with_rays(size, &rays, &vec![None; rays.len()], test)
}

/// Light that is a function of the ray and the number of a part, summed over parts that
/// rays can share.
#[derive(Debug, Clone, Copy)]
struct Known {
    parts: u32,
    light: fn(&Ray, u32) -> f32,
}

impl Method for Known {
    fn about(&self) -> About {
        About {
            name: "known".into(),
            title: "known light",
            purpose: "",
            paper: "",
            quality: "",
            qualities: &[],
            quick: &[],
            pictured: 0,
            usual: 0,
            role: Role::Variant,
            uses_shadow_map: false,
        }
    }

    fn applies(&self, _: &FrameInputs<'_>) -> Verdict {
        Verdict::Applies
    }

    fn interleaves(&self, _: &FrameInputs<'_>) -> Verdict {
        Verdict::Applies
    }
}

impl RunOn<Cpu> for Known {
    fn add_radiance(
        &self,
        frame: &Frame<'_, Cpu>,
        _: u32,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), MethodError> {
        let FrameInputs {
            rays, selection, ..
        } = frame.inputs;
        for ((i, ray), sum) in (0..).zip(rays).zip(radiance) {
            let part = selection.interleaving.part(i);
            for number in part.numbers(self.parts) {
                let light = part.weight() * (self.light)(ray, number);
                *sum = [sum[0] + light, sum[1] + 2.0 * light, sum[2], sum[3]];
            }
        }
        Ok(())
    }
}

/// The picture of a method, added to [7, 0, 0, 3].
fn picture_on<M: RunOn<Cpu>>(cpu: &Cpu, inputs: FrameInputs<'_>, method: &M) -> Vec<[f32; 4]> {
    let store = Store::<Host>::new();
    let frame = Frame::new(cpu, inputs, &store).unwrap();
    let mut radiance = vec![[7.0, 0.0, 0.0, 3.0]; inputs.rays.len()];
    method.add_radiance(&frame, 1, &mut radiance).unwrap();
    for pixel in &radiance {
        assert_eq!([pixel[2], pixel[3]], [0.0, 3.0]);
        assert!((pixel[1] - 2.0 * (pixel[0] - 7.0)).abs() < 1e-4);
    }
    radiance
}

/// The second channel, which is twice the light.
fn light<M: RunOn<Cpu>>(inputs: FrameInputs<'_>, method: &M) -> Vec<f32> {
    let picture = picture_on(&Cpu::new(), inputs, method);
    picture.iter().map(|pixel| 0.5 * pixel[1]).collect()
}

fn reductions() -> impl Iterator<Item = Reduction> {
    (1..=4).flat_map(|block| {
        (1..=4).flat_map(move |window| {
            [Filter::Bilateral, Filter::Gaussian]
                .map(|filter| Reduction::new(block, window).unwrap().with_filter(filter))
        })
    })
}

const SIZES: [[u32; 2]; 6] = [[1, 1], [2, 1], [1, 5], [7, 5], [16, 9], [13, 31]];

/// What is the same for all rays and parts: rounding of a mean of at most 81 parts.
#[test]
fn constant_light_stays_constant_in_pictures_of_any_size() {
    let constant = Known {
        parts: 1,
        light: |_, _| 3.0,
    };
    let many = Known {
        parts: 144,
        light: |_, _| 3.0 / 144.0,
    };
    for size in SIZES {
        with_view(size, |inputs| {
            for reduction in reductions() {
                let of_parts = light(inputs, &Reduced::new(many, reduction));
                let mut whole = Vec::new();
                if reduction.window() == 1 {
                    whole = light(inputs, &Reduced::new(constant, reduction));
                }
                for light in of_parts.into_iter().chain(whole) {
                    assert!((light - 3.0).abs() < 1e-5, "{size:?} {reduction:?} {light}");
                }
            }
        });
        // All sky.
        with_lengths(
            size,
            |_, _| f32::INFINITY,
            |inputs| {
                let quarter = Reduced::new(constant, Reduction::QUARTER);
                assert!(
                    light(inputs, &quarter)
                        .iter()
                        .all(|l| (l - 3.0).abs() < 1e-5)
                );
                assert_eq!(quarter.in_full(&inputs).unwrap(), 0.0);
            },
        );
    }
}

#[test]
fn nothing_left_out_is_the_method_bit_for_bit() {
    let method = Known {
        parts: 5,
        light: |ray, part| ray.direction().x.abs() * (part as f32 + 0.3),
    };
    with_view([13, 7], |inputs| {
        let own = picture_on(&Cpu::new(), inputs, &method);
        let none = Reduced::new(method, Reduction::new(1, 1).unwrap());
        assert_eq!(picture_on(&Cpu::new(), inputs, &none), own);
        // A part of a picture has no neighbours; the method runs as it is.
        let twice = Reduced::new(Reduced::new(method, Reduction::QUARTER), Reduction::NONE);
        let once = Reduced::new(method, Reduction::QUARTER);
        let expected = picture_on(&Cpu::new(), inputs, &once);
        assert_eq!(picture_on(&Cpu::new(), inputs, &twice), expected);
        let inside = Reduced::new(once, Reduction::QUARTER);
        assert_eq!(picture_on(&Cpu::new(), inputs, &inside), expected);
    });
}

/// Light that depends on the distance alone, at a wall before another.
#[test]
fn no_pixel_takes_light_from_across_a_step_in_depth() {
    let side = Known {
        parts: 144,
        light: |ray, _| f32::from(u8::from(ray.length() > 6.0)) / 144.0,
    };
    // A straight edge, a slanted one, a corner, a thin pole, a hole; sky or wall behind.
    let shapes: [fn(u32, u32) -> bool; 5] = [
        |x, _| x < 11,
        |x, y| 2 * x + y < 30,
        |x, y| x > 8 && y > 6,
        |x, _| x == 9,
        |x, y| x != 13 || y != 8,
    ];
    for is_near in shapes {
        for far in [9.0, f32::INFINITY] {
            let length = |x, y| if is_near(x, y) { 4.0 } else { far };
            with_lengths([25, 18], length, |inputs| {
                for reduction in reductions() {
                    let picture = light(inputs, &Reduced::new(side, reduction));
                    if reduction.filter() == Filter::Gaussian {
                        continue;
                    }
                    for (ray, light) in inputs.rays.iter().zip(picture) {
                        let expected = f32::from(u8::from(ray.length() > 6.0));
                        assert!((light - expected).abs() < 1e-5, "{reduction:?} {light}");
                    }
                }
            });
        }
    }
    // The Gaussian has a halo, which is what it is there to show.
    with_lengths(
        [25, 18],
        |x, _| if x < 11 { 4.0 } else { 9.0 },
        |inputs| {
            let gaussian = Reduction::QUARTER.with_filter(Filter::Gaussian);
            let picture = light(inputs, &Reduced::new(side, gaussian));
            assert!(picture.iter().any(|l| *l > 0.1 && *l < 0.9));
        },
    );
}

/// Normals separate what lengths do not: two walls that meet in an edge.
#[test]
fn surfaces_that_are_turned_from_each_other_are_apart() {
    let tracer = Tracer::new(&geometry());
    let size = [64, 36];
    let view = View::new(&Cpu::new(), &camera(), &tracer, size[0], size[1]).unwrap();
    let is_wall = |hit: &Option<Hit>| hit.is_some_and(|hit| hit.triangle >= 2);
    let walls: Vec<bool> = view.hits().iter().map(is_wall).collect();
    with_rays(size, view.rays(), view.hits(), |inputs| {
        let choice = Choice::new(&Cpu::new(), &inputs, Reduction::QUARTER).unwrap();
        let seen = super::resemblance::Seen {
            rays: inputs.rays,
            planes: &choice.planes,
            matters: true,
        };
        let (mut along, mut across) = (0, 0);
        for pixel in 0..walls.len() - 64 {
            let below = pixel + 64;
            let alike = seen.resemblance(pixel, below);
            match (walls[pixel], walls[below]) {
                (true, true) => {
                    assert!(alike > 0.99, "{alike}");
                    along += 1;
                }
                // The wall stands on the floor: the same length, a right angle.
                (true, false) => {
                    assert_eq!(alike, 0.0);
                    across += 1;
                }
                _ => {}
            }
        }
        assert!(along > 100 && across > 5, "{along} {across}");
        // The floor up to 20 m away holds together, whose rows are metres apart there.
        for pixel in 0..walls.len() - 64 {
            let here = inputs.rays[pixel].length();
            if here < 20.0 && !walls[pixel] && !walls[pixel + 64] {
                assert!(seen.resemblance(pixel, pixel + 64) > 0.9, "{here}");
            }
        }
        assert!(choice.in_full() < 0.03, "{}", choice.in_full());
    });
}

/// A smooth picture is interpolated with an error of second order: a quarter of it at
/// half the distance of samples.
#[test]
fn the_error_of_a_smooth_picture_falls_with_the_size_of_blocks() {
    let smooth = Known {
        parts: 1,
        light: |ray, _| {
            let d = ray.direction();
            2.0 + (9.0 * d.x).sin() * (7.0 * d.y).cos()
        },
    };
    with_lengths(
        [65, 49],
        |_, _| 5.0,
        |inputs| {
            let exact = light(inputs, &smooth);
            let error = |block| {
                let reduction = Reduction::new(block, 1).unwrap();
                let picture = light(inputs, &Reduced::new(smooth, reduction));
                let squares = exact.iter().zip(picture).map(|(e, p)| (e - p).powi(2));
                (squares.sum::<f32>() / exact.len() as f32).sqrt()
            };
            let errors = [8, 4, 2].map(error);
            for pair in errors.windows(2) {
                assert!(pair[0] > 3.5 * pair[1], "{errors:?}");
            }
            // h²/8 of the second derivatives, 9² + 7², for h of 2 pixels of 0.02.
            assert!(errors[2] < 0.026, "{errors:?}");
        },
    );
}

/// Where all rays have the same light, a window has all parts and their mean is the
/// sum; parts of very different light leave no pattern.
#[test]
fn a_window_sees_every_part() {
    let parts = Known {
        parts: 36,
        light: |_, part| (part * part) as f32,
    };
    let expected: f32 = (0..36_u16).map(|part| f32::from(part * part)).sum();
    with_view([40, 23], |inputs| {
        for block in 1..=2 {
            for window in 2..=4 {
                let reduction = Reduction::new(block, window).unwrap();
                for light in light(inputs, &Reduced::new(parts, reduction)) {
                    assert!((light - expected).abs() < 1e-5 * expected, "{light}");
                }
            }
        }
    });
}

#[test]
fn pictures_do_not_depend_on_threads() {
    let method = Known {
        parts: 20,
        light: |ray, part| ray.direction().y.abs() + part as f32 * ray.direction().x.abs(),
    };
    with_view([31, 17], |inputs| {
        for reduction in reductions() {
            let method = Reduced::new(method, reduction);
            let one = picture_on(&Cpu::single_threaded(), inputs, &method);
            let three = picture_on(&Cpu::with_threads(3).unwrap(), inputs, &method);
            assert_eq!(one, three, "{reduction:?}");
        }
    });
}

/// A method that keeps what it was told.
#[derive(Debug, Default)]
struct Told(Mutex<Vec<(Vec<u32>, Interleaving)>>);

impl Method for Told {
    fn about(&self) -> About {
        About {
            name: "told".into(),
            ..Known {
                parts: 0,
                light: |_, _| 0.0,
            }
            .about()
        }
    }

    fn applies(&self, _: &FrameInputs<'_>) -> Verdict {
        Verdict::Applies
    }
}

impl RunOn<Cpu> for Told {
    fn add_radiance(
        &self,
        frame: &Frame<'_, Cpu>,
        _: u32,
        _: &mut Vec<[f32; 4]>,
    ) -> Result<(), MethodError> {
        let inputs = frame.inputs;
        let pixels = inputs.selection.pixels.unwrap().to_vec();
        assert_eq!(pixels.len(), inputs.rays.len());
        assert_eq!(pixels.len(), inputs.hits.len());
        let mut told = self.0.lock().unwrap();
        told.push((pixels, inputs.selection.interleaving));
        Ok(())
    }
}

#[test]
fn the_method_runs_once_and_is_told_which_pixels_its_rays_are() {
    with_lengths(
        [9, 6],
        |x, y| if (x, y) == (3, 3) { 2.0 } else { f32::INFINITY },
        |inputs| {
            let method = Reduced::new(Told::default(), Reduction::new(2, 2).unwrap());
            light_of_nothing(inputs, &method);
            let verdict = method.applies(&inputs);
            assert!(verdict.reason().unwrap().contains("share"), "{verdict:?}");
            let told = method.inner().0.lock().unwrap();
            let [(pixels, interleaving)] = &told[..] else {
                panic!("{told:?}");
            };
            // Samples in columns 0, 2, 4, 6, 8 and rows 0, 2, 4, 5: 3 × 2 windows.
            assert_eq!(*interleaving, Interleaving::new(4, 6));
            assert_eq!(pixels[..3], [0, 4, 8]);
            assert_eq!(pixels[6..9], [2, 6, 8], "the last window lacks a column");
            assert_eq!(pixels[24..], [30], "which nothing resembles");
            assert!((method.in_full(&inputs).unwrap() - 1.0 / 54.0).abs() < 1e-9);
            let notes = method.notes(&inputs);
            assert!(
                notes.iter().any(|note| note.starts_with("1.9 %")),
                "{notes:?}"
            );
            assert_eq!(method.about().name, "told 2x2 quarter");
        },
    );
}

fn light_of_nothing(inputs: FrameInputs<'_>, method: &impl RunOn<Cpu>) {
    assert!(light(inputs, method).iter().all(|light| *light == 0.0));
}

#[test]
fn what_is_no_picture_is_an_error() {
    let method = Reduced::new(
        Known {
            parts: 1,
            light: |_, _| 1.0,
        },
        Reduction::QUARTER,
    );
    with_view([8, 6], |inputs| {
        let cpu = Cpu::new();
        let store = Store::<Host>::new();
        for inputs in [
            FrameInputs {
                size: [7, 6],
                ..inputs
            },
            FrameInputs {
                hits: &inputs.hits[1..],
                ..inputs
            },
        ] {
            let frame = Frame::new(&cpu, inputs, &store).unwrap();
            let mut radiance = vec![[0.0; 4]; inputs.rays.len()];
            let error = method.add_radiance(&frame, 1, &mut radiance).unwrap_err();
            assert!(error.to_string().contains("picture"), "{error}");
        }
        let choice = Choice::new(&cpu, &inputs, Reduction::QUARTER).unwrap();
        let rays = inputs.rays.to_vec();
        let filling = Filling::upload(&cpu, &choice, &rays).unwrap();
        let gathered = vec![[0.0; 4]; choice.rays().len()];
        for (gathered, pixels) in [(&gathered[1..], 48), (&gathered[..], 47)] {
            let mut radiance = vec![[0.0; 4]; pixels];
            let error = cpu.fill_picture(&filling, &gathered.to_vec(), &mut radiance);
            assert!(error.is_err());
        }
        let few = rays[1..].to_vec();
        assert!(Filling::upload(&cpu, &choice, &few).is_err());
    });
}

#[cfg(feature = "wgpu")]
mod on_a_gpu {
    use gpu_backend::testing::{self, Shader};
    use gpu_backend::{Backend, Download, assert_same_layout};
    use reference::tolerances::Allowed;

    use super::super::choice::NONE;
    use super::super::gpu::{GridRecord, REDUCED};
    use super::super::resemblance::{FARTHEST, PER_LENGTH, PER_TURN};
    use super::*;

    #[test]
    fn the_shader_is_valid_and_has_the_constants_of_rust() {
        let shader = Shader::new(&REDUCED).unwrap();
        assert_same_layout!(
            shader,
            "Grid",
            GridRecord {
                columns,
                rows,
                sample_columns,
                sample_rows,
                window_columns,
                window_count,
                block,
                window,
                bilateral,
                padding_a,
                padding_b,
                padding_c
            }
        );
        let value = |name: &str| shader.values(name).unwrap()[0];
        assert_eq!(value("NONE"), f64::from(NONE));
        for (name, expected) in [
            ("FARTHEST", FARTHEST),
            ("PER_LENGTH", PER_LENGTH),
            ("PER_TURN", PER_TURN),
        ] {
            assert_eq!(value(name) as f32, expected, "{name}");
        }
    }

    /// Light without any likeness between neighbours, on a wall, a floor to the horizon
    /// and the sky.
    #[test]
    fn it_fills_pictures_as_the_cpu_does() {
        let Some(gpu) = testing::gpu() else { return };
        let cpu = Cpu::new();
        with_view([53, 38], |inputs| {
            for reduction in reductions() {
                let choice = Choice::new(&cpu, &inputs, reduction).unwrap();
                let gathered: Vec<[f32; 4]> = (0..choice.rays().len() as u32)
                    .map(|i| {
                        let random = i.wrapping_mul(0x9E37_79B9) >> 8;
                        let light = random as f32 / (1 << 24) as f32;
                        [light, 1.0 - light, 0.5, 9.0]
                    })
                    .collect();
                let start = vec![[0.0, 0.0, 0.0, 3.0]; inputs.rays.len()];
                let rays = inputs.rays.to_vec();
                let filling = Filling::upload(&cpu, &choice, &rays).unwrap();
                let mut expected = start.clone();
                cpu.fill_picture(&filling, &gathered, &mut expected)
                    .unwrap();
                let rays = gpu.upload(&rays).unwrap();
                let filling = Filling::upload(&gpu, &choice, &rays).unwrap();
                let mut found = gpu.upload(&start).unwrap();
                let gathered = gpu.upload(&gathered).unwrap();
                gpu.fill_picture(&filling, &gathered, &mut found).unwrap();
                let found = gpu.download(&found).unwrap();
                for (e, f) in expected.iter().zip(&found) {
                    assert_eq!(f[3], 3.0);
                    for c in 0..3 {
                        // Light is at most 1.
                        let off = f64::from((e[c] - f[c]).abs());
                        let allowed = Allowed::GpuResemblance.error();
                        assert!(off <= allowed, "{reduction:?} {e:?} {f:?}");
                    }
                }
            }
        });
    }
}
