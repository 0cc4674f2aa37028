//! What a plan leaves out does not change the picture.

use glam::{Quat, Vec3};
use gpu_backend::Cpu;
use reference::random::noise;

use super::words::list;
use super::*;
use crate::airlight::EquiAngular;
use crate::scene::{Bounds, Cone, Emission, PhaseFunction};
use crate::visibility::Unshadowed;
use crate::{Gather, LitRays};

fn fog() -> Medium {
    Medium::new(
        Vec3::splat(0.1),
        Vec3::splat(0.02),
        PhaseFunction::HenyeyGreenstein { g: 0.5 },
    )
    .unwrap()
}

/// A narrow picture along -Z.
fn view() -> Vec<Ray> {
    (0..200)
        .map(|i| {
            let (x, y) = ((i % 20) as f32 / 20.0 - 0.5, (i / 20) as f32 / 10.0 - 0.5);
            let length = if i % 7 == 0 { f32::INFINITY } else { 12.0 };
            Ray::new(Vec3::ZERO, Vec3::new(x, y, -1.0), length).unwrap()
        })
        .collect()
}

/// Lights of every kind all around the view, some of them in vain.
fn lights() -> Vec<Emitter> {
    let mut all = vec![
        Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::ONE).unwrap(),
        Emitter::directional(Vec3::NEG_Y, Vec3::ZERO).unwrap(),
    ];
    let cone = Cone {
        inner: 0.1,
        outer: 0.4,
    };
    for i in 0..60_u32 {
        let unit = |k: u32| noise(u64::from(i * 9 + k));
        let position = 30.0 * Vec3::new(unit(0) - 0.5, unit(1) - 0.5, unit(2) - 0.7);
        let turn = Quat::from_euler(glam::EulerRot::YXZ, 6.3 * unit(3), 3.0 * unit(4), 0.0);
        let emission = match i % 3 {
            0 => Emission::Isotropic,
            1 => Emission::spot(turn, cone, None).unwrap(),
            _ => Emission::Cosine {
                normal: turn * Vec3::X,
            },
        };
        let intensity = if i % 10 == 9 { 0.0 } else { 5.0 };
        let range = 1.0 + 8.0 * unit(5);
        let light = Emitter::point(position, Vec3::splat(intensity), range, emission);
        all.push(light.unwrap());
    }
    all
}

fn picture<'a>(emitters: impl Iterator<Item = &'a Emitter>, medium: &Medium) -> Vec<[f32; 4]> {
    let rays = view();
    let mut radiance = vec![[0.0; 4]; rays.len()];
    let rule = EquiAngular::new(8).unwrap();
    for emitter in emitters {
        Cpu::new()
            .gather(
                &LitRays::new(&rays, emitter, medium),
                &Unshadowed,
                &rule,
                &mut radiance,
            )
            .unwrap();
    }
    radiance
}

#[test]
fn what_is_left_out_does_not_change_a_bit_of_the_picture() {
    let in_a_box = Bounds::new(Vec3::new(-4.0, -1.0, -9.0), Vec3::new(2.0, 1.0, -2.0)).unwrap();
    let nothing = Medium::new(Vec3::ZERO, Vec3::ONE, PhaseFunction::Isotropic).unwrap();
    for medium in [fog(), fog().within(in_a_box), nothing] {
        let all = lights();
        let plan = Plan::new(&all, Some(&medium), &view());
        let forced = picture(all.iter(), &medium);
        let planned = picture(plan.emitters().iter().map(|index| &all[*index]), &medium);
        assert_eq!(forced, planned);
        let skipped = all.len() - plan.emitters().len();
        assert!(skipped > 10, "{skipped} of {} were skipped", all.len());
    }
}

#[test]
fn lights_behind_all_that_the_eye_sees_are_left_out() {
    let cone = Cone {
        inner: 0.1,
        outer: 0.4,
    };
    let lamp = |position: Vec3, emission: Emission| {
        Emitter::point(position, Vec3::ONE, 2.0, emission).unwrap()
    };
    let behind = Vec3::new(0.0, 0.0, -14.5);
    let back = Emission::spot(Quat::IDENTITY, cone, None).unwrap();
    let all = [
        lamp(behind, Emission::Isotropic),
        lamp(behind + Vec3::Z, Emission::Isotropic),
        lamp(Vec3::new(0.0, 0.0, -12.01), back),
    ];
    // No ray of the view is longer than 12 m.
    let walled: Vec<Ray> = view()
        .iter()
        .map(|ray| ray.with_length(ray.length().min(12.0)))
        .collect();
    let plan = Plan::new(&all, Some(&fog()), &walled);
    assert_eq!(plan.emitters(), [1]);
    assert_eq!(plan.left_out()[0].subject, Subject::Emitters(vec![0, 2]));
    assert_eq!(plan.left_out()[0].saving.rays, 2 * walled.len() as u64);
}

#[test]
fn every_reason_is_given_where_it_holds() {
    let (all, rays) = (lights(), view());
    let reasons = |emitters: &[Emitter], medium: Option<&Medium>, rays: &[Ray]| {
        let plan = Plan::new(emitters, medium, rays);
        plan.left_out().iter().map(|l| l.reason).collect::<Vec<_>>()
    };
    let medium = fog();
    let black = Medium::new(Vec3::ZERO, Vec3::ONE, PhaseFunction::Isotropic).unwrap();
    let sun = &all[..1];
    assert_eq!(reasons(&all, None, &rays), [Reason::NoMedium]);
    assert_eq!(
        reasons(&all, Some(&black), &rays),
        [Reason::NothingScattered]
    );
    assert_eq!(reasons(&[], Some(&medium), &rays), [Reason::NoLight]);
    assert_eq!(
        reasons(sun, Some(&medium), &rays),
        [Reason::OnlyDirectionalLight]
    );
    assert_eq!(
        reasons(sun, Some(&medium), &[]),
        [Reason::NeverMeetsTheView]
    );
    let mixed = reasons(&all, Some(&medium), &rays);
    assert_eq!(mixed, [Reason::Dark, Reason::NeverMeetsTheView]);
}

#[test]
fn a_plan_can_be_read() {
    let all = lights();
    let text = Plan::new(&all[..2], Some(&fog()), &view()).to_string();
    assert_eq!(
        text,
        "runs: airlight of emitter 0\n\
         runs: if marched or voxelized, shadow map of emitter 0\n\
         left out: airlight of emitter 1 (no intensity; saves 200 rays)\n\
         left out: equi-angular steps (a directional light has no equi-angular variable)\n"
    );
    assert_eq!(list(&[0, 1, 2, 5, 7, 8]), "emitters 0 to 2, 5, 7, 8");
}
