use glam::{Quat, Vec3};

use super::*;
use crate::scene::{Bounds, Cone, Emission, PhaseFunction};
use crate::visibility::{PointVisibility, Unshadowed};

fn fog(sigma_s: f32, phase: PhaseFunction) -> Medium {
    let sigma_s = Vec3::new(sigma_s, sigma_s, 0.5 * sigma_s);
    Medium::new(sigma_s, 0.1 * sigma_s, phase).unwrap()
}

fn lamp(emission: Emission) -> Emitter {
    let position = Vec3::new(0.5, 2.0, -0.3);
    Emitter::point(position, Vec3::new(3.0, 2.0, 1.0), f32::INFINITY, emission).unwrap()
}

fn spot(inner: f32, outer: f32) -> Emission {
    Emission::spot(Quat::from_rotation_x(-0.9), Cone { inner, outer }, None).unwrap()
}

fn normals() -> impl Iterator<Item = Vec3> {
    (0..40).map(|i| {
        let (y, turn) = (1.0 - (i as f32 + 0.5) / 20.0, 2.4 * i as f32);
        let r = (1.0 - y * y).sqrt();
        Vec3::new(r * turn.cos(), y, r * turn.sin())
    })
}

#[test]
fn quadrature_and_closed_form_agree_where_there_is_one() {
    let fine = Quadrature::new(Unshadowed, 24).unwrap();
    for sigma in [0.003, 0.1, 1.0] {
        let fog = fog(sigma, PhaseFunction::Isotropic);
        let closed = ClosedForm::new(&fog);
        let light = lamp(Emission::Isotropic);
        for normal in normals() {
            let a = closed.irradiance(Vec3::ZERO, normal, &light, &fog);
            let b = fine.irradiance(Vec3::ZERO, normal, &light, &fog);
            let error = ((a - b) / a).abs().max_element();
            // At the smallest depth, 0.007, the light ends within that of φ + γ = π.
            assert!(error < 3e-3, "sigma {sigma}, {normal}: {a} {b}");
        }
    }
}

#[test]
fn sunlight_in_even_fog_is_a_quarter_of_the_albedo_however_a_surface_is_turned() {
    let fog = fog(0.1, PhaseFunction::Isotropic);
    let sun = Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::ONE).unwrap();
    let closed = ClosedForm::new(&fog);
    for normal in normals() {
        let light = closed.irradiance(Vec3::ZERO, normal, &sun, &fog);
        let expected = 0.25 * fog.sigma_s() / fog.sigma_t();
        assert!((light - expected).abs().max_element() < 1e-6, "{light}");
    }
}

#[test]
fn sunlight_of_opposite_sides_is_all_that_is_scattered_between_the_axis_and_the_side() {
    // ∫ |n·ω| p dω over both sides: 1 along a needle-sharp peak, ½ for an even one.
    for (phase, along) in [
        (PhaseFunction::Isotropic, 0.5),
        (PhaseFunction::Rayleigh, 0.5625),
        (PhaseFunction::HenyeyGreenstein { g: 0.999 }, 1.0),
    ] {
        let fog = fog(0.1, phase);
        let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
        let closed = ClosedForm::new(&fog);
        let of = |normal| closed.irradiance(Vec3::ZERO, normal, &sun, &fog).x;
        let both = (of(Vec3::Y) + of(Vec3::NEG_Y)) * fog.sigma_t().x / fog.sigma_s().x;
        assert!((both - along).abs() < 0.01, "{phase:?}: {both}");
    }
}

#[test]
fn a_box_around_everything_changes_nothing() {
    let quadrature = Quadrature::new(Unshadowed, 24).unwrap();
    let fog = fog(0.2, PhaseFunction::HenyeyGreenstein { g: 0.4 });
    let everywhere = Bounds::new(Vec3::splat(-900.0), Vec3::splat(900.0)).unwrap();
    for emission in [
        Emission::Isotropic,
        spot(0.2, 0.5),
        Emission::Cosine { normal: Vec3::X },
    ] {
        let light = lamp(emission);
        for normal in normals() {
            let open = quadrature.irradiance(Vec3::ZERO, normal, &light, &fog);
            let boxed = quadrature.irradiance(Vec3::ZERO, normal, &light, &fog.within(everywhere));
            let error = (open - boxed).abs().max_element();
            assert!(error <= 2e-4 * open.max_element(), "{open} {boxed}");
        }
    }
}

#[test]
fn shadows_take_light_away_and_only_that() {
    struct Half;
    impl PointVisibility for Half {
        type Share = f32;
        fn visibility(&self, point: Vec3) -> f32 {
            if point.x > 0.3 { 1.0 } else { 0.0 }
        }
    }
    struct OtherHalf;
    impl PointVisibility for OtherHalf {
        type Share = f32;
        fn visibility(&self, point: Vec3) -> f32 {
            1.0 - Half.visibility(point)
        }
    }
    let fog = fog(0.2, PhaseFunction::Isotropic);
    let sun = Emitter::directional(Vec3::new(0.1, -1.0, 0.0), Vec3::ONE).unwrap();
    for light in [lamp(Emission::Isotropic), lamp(spot(0.1, 0.8)), sun] {
        let of = |evaluator: &dyn SurfaceEvaluator| {
            evaluator.irradiance(Vec3::ZERO, Vec3::Y, &light, &fog).x
        };
        let all = of(&Quadrature::new(Unshadowed, 8).unwrap());
        let a = of(&Quadrature::new(Half, 8).unwrap());
        let b = of(&Quadrature::new(OtherHalf, 8).unwrap());
        assert!(
            a > 0.0 && b > 0.0 && (a + b - all).abs() < 1e-5 * all,
            "{a} {b} {all}"
        );
    }
}

#[test]
fn what_is_not_covered_is_refused_with_the_reason() {
    let even = fog(0.1, PhaseFunction::Isotropic);
    let hazy = fog(0.1, PhaseFunction::HenyeyGreenstein { g: 0.5 });
    let boxed = even.within(Bounds::new(Vec3::ZERO, Vec3::ONE).unwrap());
    let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
    let short = Emitter::point(Vec3::Y, Vec3::ONE, 3.0, Emission::Isotropic).unwrap();
    let closed = ClosedForm::new(&even);
    let even_lamp = lamp(Emission::Isotropic);
    assert_eq!(closed.covers(&even_lamp, &even), Ok(()));
    assert_eq!(closed.covers(&sun, &even), Ok(()));
    assert_eq!(closed.covers(&even_lamp, &hazy), Err(NotCovered::Phase));
    assert_eq!(closed.covers(&sun, &hazy), Err(NotCovered::OtherPhase));
    assert_eq!(closed.covers(&even_lamp, &boxed), Err(NotCovered::Bounds));
    assert_eq!(closed.covers(&short, &even), Err(NotCovered::Range));
    assert_eq!(
        closed.covers(&lamp(spot(0.1, 0.2)), &even),
        Err(NotCovered::Emission)
    );
    let points = vec![SurfacePoint::default()];
    let lit = LitSurfaces {
        points: &points,
        emitter: &short,
        medium: &even,
    };
    let mut radiance = vec![[0.0; 4]];
    let error = Cpu::new()
        .add_surface_scattering(&lit, &closed, &mut radiance)
        .unwrap_err();
    assert!(error.to_string().contains("unlimited range"), "{error}");
    assert!(Quadrature::new(Unshadowed, 0).is_err() && Quadrature::new(Unshadowed, 65).is_err());
}

#[test]
fn no_place_of_light_and_surface_gives_nan() {
    let fog = fog(0.5, PhaseFunction::HenyeyGreenstein { g: -0.3 });
    let boxed = fog.within(Bounds::new(Vec3::splat(-1.0), Vec3::ONE).unwrap());
    let quadrature = Quadrature::new(Unshadowed, 6).unwrap();
    let at = |offset: Vec3| Vec3::new(0.5, 2.0, -0.3) + offset;
    for medium in [fog, boxed] {
        for emission in [Emission::Isotropic, spot(0.0, 0.001), spot(0.3, 1.5)] {
            let light = lamp(emission);
            for offset in [0.0, 1e-20, 1e-6, 1.0, 1e4, 1e9] {
                for normal in [Vec3::Y, Vec3::NEG_Y, Vec3::X] {
                    let position = at(offset * Vec3::Y);
                    let light = quadrature.irradiance(position, normal, &light, &medium);
                    assert!(light.is_finite() && light.min_element() >= 0.0, "{light}");
                }
            }
        }
    }
}

#[cfg(feature = "wgpu")]
mod shaders {
    use gpu_backend::assert_same_layout;
    use gpu_backend::gpu::InShader;
    use gpu_backend::testing::Shader;

    use super::super::gpu::{PARTS, STORAGE, Scene, shader};
    use super::*;

    /// Valid, and within WebGPU's eight storage buffers.
    fn complete<S: InShader<SurfaceScatteringSlot>>() -> Shader {
        let assembly = shader::<S>().unwrap();
        let storage = assembly.bindings().iter().filter(|b| b.kind.is_storage());
        assert!(STORAGE + storage.count() <= 8);
        Shader::new(&assembly.finish(PARTS)).unwrap()
    }

    #[test]
    fn every_evaluator_compiles_and_records_are_those_of_rust() {
        complete::<ClosedForm>();
        let shader = complete::<Quadrature<Unshadowed>>();
        assert_same_layout!(
            shader,
            "light_SurfacePoint",
            SurfacePoint {
                position,
                openness,
                normal,
                padding_a,
                response,
                padding_b
            }
        );
        assert_same_layout!(
            shader,
            "Scene",
            Scene {
                emitter,
                medium,
                points,
                padding_a,
                padding_b,
                padding_c
            }
        );
    }

    #[cfg(feature = "shadow-map")]
    #[test]
    fn shadow_maps_compile_with_the_quadrature() {
        use crate::shadow_map::ShadowMap;
        use gpu_backend::gpu::GpuMemory;

        complete::<Quadrature<ShadowMap<GpuMemory>>>();
        complete::<Quadrature<&ShadowMap<GpuMemory>>>();
    }
}
