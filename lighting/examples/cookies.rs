//! What steps through the cookie of a spotlight err by and cost, of several ways to place
//! them: the tables of `methods::textured`.
//!
//! ```console
//! $ cargo run --release --package crepuscular-lighting --example cookies \
//!       --features methods,procedural
//! ```
//!
//! Errors are root mean squares relative to the mean, against the exact integral over the
//! cookie behind the exact runs of the shadow map. Times are those of the fastest of three
//! gathers on the CPU, in multiples of that of a march of as many steps.

use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

use glam::{Quat, Vec3};
use gpu_backend::{Cpu, Host};
use lighting::airlight::{Daylight, EquiAngular, Midpoint, Quadrature};
use lighting::methods::epipolar::MapRuns;
use lighting::methods::hybrid::ShadowVolumes;
use lighting::methods::textured::{MipCookie, Placement, ShadowSpans, Textured, bare};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::scene::{Cone, Emission, Geometry, Medium, Mesh, PhaseFunction, Scene, Texture};
use lighting::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use lighting::visibility::{March, Spacing};
use lighting::{AirlightEvaluator, Emitter, Gather, LitRays, Ray, VisibilitySource};
use reference::random::noise;

/// Texels per side of shadow maps.
const MAP: u32 = 1024;

const STEPS: [u32; 5] = [8, 16, 32, 64, 128];

type Picture = Vec<[f32; 4]>;
type Source<'a> = Textured<ShadowSpans<&'a ShadowMap<Host>, Host>, Host>;

/// A light, its fog, its shadows and the rays of a view.
struct Case {
    name: &'static str,
    light: Emitter,
    medium: Medium,
    rays: Vec<Ray>,
    map: ShadowMap<Host>,
    volumes: Arc<ShadowVolumes<Host>>,
    cookie: Arc<MipCookie<Host>>,
    /// Length of the beam.
    reach: f32,
}

impl Case {
    fn new(
        name: &'static str,
        (light, reach): (Emitter, f32),
        (geometry, medium): (&Geometry, Medium),
        rays: Vec<Ray>,
    ) -> Result<Self, Box<dyn Error>> {
        let cpu = Cpu::new();
        let Emitter::Point(point) = &light else {
            return Err("not a spotlight".into());
        };
        let Emission::Spot(spot) = point.emission() else {
            return Err("not a spotlight".into());
        };
        let cookie = MipCookie::new(spot.texture().ok_or("no cookie")?);
        let casters = Casters::upload(&cpu, geometry)?;
        Ok(Self {
            name,
            medium,
            rays,
            map: cpu.shadow_map(&casters, &light, MAP)?,
            volumes: Arc::new(ShadowVolumes::new(&cpu, geometry, &light, MAP)?),
            cookie: Arc::new(cookie),
            light,
            reach,
        })
    }

    fn gathered<V, A>(
        &self,
        light: &Emitter,
        source: &V,
        airlight: &A,
    ) -> Result<(f64, Picture), Box<dyn Error>>
    where
        V: VisibilitySource,
        A: AirlightEvaluator,
    {
        let mut best = (f64::INFINITY, Picture::new());
        let lit = LitRays::new(&self.rays, light, &self.medium);
        for _ in 0..3 {
            let mut radiance = vec![[0.0; 4]; self.rays.len()];
            let clock = Instant::now();
            Cpu::new().gather(&lit, source, airlight, &mut radiance)?;
            let seconds = clock.elapsed().as_secs_f64();
            if seconds < best.0 {
                best = (seconds, radiance);
            }
        }
        Ok(best)
    }

    fn textured(
        &self,
        (steps, shadow_steps): (u32, u32),
        placement: Placement,
        finer: f32,
    ) -> Result<(f64, Picture), Box<dyn Error>> {
        let source = self.source((steps, shadow_steps), placement)?;
        let source = source.with_finer_levels(finer);
        self.gathered(&bare(&self.light), &source, &EquiAngular::new(1)?)
    }

    fn source(
        &self,
        (steps, shadow_steps): (u32, u32),
        placement: Placement,
    ) -> Result<Source<'_>, Box<dyn Error>> {
        let volumes = Some(self.volumes.clone());
        let light = &self.light;
        let shadows = ShadowSpans::new(&self.map, volumes, light, shadow_steps, placement)?;
        let cookie = Some(self.cookie.clone());
        Ok(Textured::new(shadows, light, cookie, steps, placement))
    }
}

/// Relative to the mean.
fn rmse(found: &Picture, truth: &Picture) -> f64 {
    let channels = |all: &Picture| -> Vec<f64> {
        let light = all.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]);
        light.map(f64::from).collect()
    };
    let (found, truth) = (channels(found), channels(truth));
    let count = truth.len() as f64;
    let mean = truth.iter().sum::<f64>() / count;
    let squares = found.iter().zip(&truth).map(|(f, t)| (f - t).powi(2));
    (squares.sum::<f64>() / count).sqrt() / mean
}

/// A leaded window of 256² texels in a beam of 50°, a fence below it, and rays across the
/// beam, towards the light and along the beam.
fn windows() -> Result<Vec<Case>, Box<dyn Error>> {
    let side = 256_u32;
    let texels = (0..side * side).map(|i| {
        let at = [i % side, i / side].map(|t| (t as f32 + 0.5) / side as f32 * 9.0);
        let lead = at.map(|t| ((t - t.round()).abs() / 0.08).min(1.0));
        let pane = u64::from(at[0].round() as u32 * 16 + at[1].round() as u32);
        lead[0] * lead[1] * Vec3::from([0, 1, 2].map(|c| 0.1 + noise(3 * pane + c)))
    });
    let window = Texture::new(side, side, texels.collect())?;
    let outer = 25_f32.to_radians();
    let cone = Cone {
        inner: 0.9 * outer,
        outer,
    };
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let emission = Emission::spot(down, cone, Some(window))?;
    let light = Emitter::point(Vec3::ZERO, Vec3::ONE, 8.0, emission)?;
    let mut mesh = Mesh::default();
    for i in 0..6 {
        let x = 0.5 * (i as f32 - 2.5);
        let first = mesh.positions.len() as u32;
        let corner = |dx: f32, z: f32| Vec3::new(x + dx, -2.2, z);
        mesh.positions
            .extend([corner(-0.06, -2.0), corner(0.06, -2.0), corner(0.0, 2.0)]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    let geometry = Geometry::new(&Scene::from(mesh))?;
    let medium = Medium::new(Vec3::splat(0.2), Vec3::ZERO, PhaseFunction::Isotropic)?;
    let mut cases = Vec::new();
    for (name, eye) in [
        ("across the beam", Vec3::new(3.0, -2.0, 0.3)),
        ("towards the light", Vec3::new(0.3, -6.0, 0.4)),
        ("along the beam", Vec3::new(0.05, 0.05, 0.02)),
    ] {
        let rays = (0..4000_u64).filter_map(|i| {
            let wander = [0, 1, 2].map(|k| noise(7 * i + k) - 0.5);
            let wander = Vec3::from(wander);
            let aim = match name {
                "across the beam" => Vec3::new(0.0, -2.0, 0.0) + wander,
                "towards the light" => 0.15 * wander,
                _ => Vec3::new(0.0, -4.0, 0.0) + 2.0 * wander,
            };
            Ray::new(eye, aim - eye, 6.5)
        });
        let rays = rays.collect();
        cases.push(Case::new(
            name,
            (light.clone(), 8.0),
            (&geometry, medium),
            rays,
        )?);
    }
    Ok(cases)
}

fn main() -> Result<(), Box<dyn Error>> {
    let cpu = Cpu::new();
    let mut scene = Embedded::TexturedSpot.build(1);
    let geometry = Geometry::new(&scene)?;
    scene.complete(geometry.bounds())?;
    let camera = scene.camera.ok_or("no camera")?;
    let view = View::new(&cpu, &camera, &Tracer::new(&geometry), 320, 180)?;
    let light = scene.lights[0].emitters(1)?.remove(0);
    let fog = (&geometry, scene.medium.ok_or("no medium")?);
    let rays = view.rays().to_vec();
    let mut cases = vec![Case::new("textured-spot", (light, 12.0), fog, rays)?];
    cases.extend(windows()?);
    for case in &cases {
        let exact = Quadrature::with_tolerance(case.medium.phase(), 1e-5)?;
        let (seconds, truth) = case.gathered(&case.light, &MapRuns::walked(&case.map), &exact)?;
        let mut of_march = Vec::new();
        for steps in STEPS {
            let march = March::new(&case.map, steps, Spacing::Distance);
            of_march.push(case.gathered(&case.light, &march, &Midpoint)?);
        }
        println!(
            "{}: exact in {:.1} x the march of 64 steps",
            case.name,
            seconds / of_march[3].0
        );
        let row = |name: &str, way: &dyn Fn(u32) -> Result<(f64, Picture), Box<dyn Error>>| {
            print!("{name:32}");
            for (steps, (of_march, _)) in STEPS.iter().zip(&of_march) {
                let (seconds, picture) = way(*steps)?;
                print!(
                    "{:8.2} % {:5.2} x",
                    100.0 * rmse(&picture, &truth),
                    seconds / of_march
                );
            }
            println!();
            Ok::<(), Box<dyn Error>>(())
        };
        row("march x midpoint", &|steps| {
            let march = March::new(&case.map, steps, Spacing::Distance);
            case.gathered(&case.light, &march, &Midpoint)
        })?;
        row("light-space x gauss-1", &|steps| {
            let march = March::new(&case.map, steps, Spacing::Picture);
            case.gathered(&case.light, &march, &EquiAngular::new(1)?)
        })?;
        let reach = case.reach;
        row("uniform in the span", &|n| {
            case.textured((n, 2 * n), Placement::Span, 1.0)
        })?;
        row("lengths by the angle to the axis", &|n| {
            case.textured((n, 2 * n), Placement::Length { reach }, 1.0)
        })?;
        for (name, finer) in [
            ("no mip level", 32.0),
            ("mip = step", 0.0),
            ("one finer", 1.0),
        ] {
            row(&format!("angles at the light, {name}"), &|n| {
                case.textured((n, 2 * n), Placement::Angle, finer)
            })?;
        }
        for (name, ratio) in [
            ("1 shadow step", 1),
            ("4 shadow steps", 4),
            ("8 shadow steps", 8),
        ] {
            row(&format!("one finer, {name}"), &|n| {
                case.textured((n, ratio * n), Placement::Angle, 1.0)
            })?;
        }
        for metres in [1.0, 2.0, 4.0, 8.0] {
            let source = case.source((128, 256), Placement::Angle)?;
            let (_, picture) =
                case.gathered(&bare(&case.light), &source, &Daylight::new(metres)?)?;
            let sum = |all: &Picture| {
                all.iter()
                    .map(|p| f64::from(p[0] + p[1] + p[2]))
                    .sum::<f64>()
            };
            println!(
                "daylight at {metres} m: {:.0} %, {:.2} times the light",
                100.0 * rmse(&picture, &truth),
                sum(&picture) / sum(&truth)
            );
        }
    }
    Ok(())
}
