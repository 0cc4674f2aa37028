use glam::Vec3;

use super::*;
use crate::scene::{Bounds, Emission, Medium, PhaseFunction};
use crate::visibility::Unshadowed;
use crate::{Emitter, Ray};

fn lamp() -> Emitter {
    let position = Vec3::new(0.0, 2.0, -3.0);
    Emitter::point(position, Vec3::ONE, 50.0, Emission::Isotropic).unwrap()
}

fn fog() -> Medium {
    Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic).unwrap()
}

fn slabs(ray: &Ray, medium: &Medium, slices: Slices<Unshadowed>) -> Vec<Interval> {
    let light = lamp();
    let path = LightPath::new(ray, &light, medium).unwrap();
    let mut lit = Vec::new();
    slices.lit_intervals(&path, &mut lit);
    lit.iter().map(|part| part.interval).collect()
}

#[test]
fn a_slab_counts_if_its_plane_is_before_the_surface() {
    let slices = |count| Slices::new(Unshadowed, count, Vec3::NEG_Z, [0.0, 10.0]);
    for (length, whole) in [(10.0, 10), (5.4, 5), (5.6, 6), (0.4, 0), (0.6, 1)] {
        let ray = Ray::new(Vec3::ZERO, Vec3::NEG_Z, length).unwrap();
        let found = slabs(&ray, &fog(), slices(10));
        assert_eq!(found.len(), whole, "{length}");
        for (i, slab) in found.iter().enumerate() {
            let expected = Interval::new(i as f32, (i as f32 + 1.0).min(length));
            assert_eq!(*slab, expected);
        }
    }
    // Aslant, planes are crossed later.
    let ray = Ray::new(Vec3::ZERO, Vec3::new(1.0, 0.0, -1.0), 20.0).unwrap();
    let found = slabs(&ray, &fog(), slices(10));
    assert_eq!(found.len(), 10);
    assert!((found[9].end - 10.0 * 2_f32.sqrt()).abs() < 1e-4);
}

#[test]
fn slabs_begin_with_the_fog_and_none_are_thicker_than_can_be() {
    let bounds = Bounds::new(Vec3::new(-5.0, -5.0, -9.0), Vec3::new(5.0, 5.0, -4.25)).unwrap();
    let slices = Slices::new(Unshadowed, 10, Vec3::NEG_Z, [0.0, 10.0]);
    let ray = Ray::new(Vec3::ZERO, Vec3::NEG_Z, 20.0).unwrap();
    let found = slabs(&ray, &fog().within(bounds), slices);
    let whole: Vec<_> = [(4.25, 5.0), (5.0, 6.0), (6.0, 7.0), (7.0, 8.0), (8.0, 9.0)]
        .map(|(start, end)| Interval::new(start, end))
        .into();
    assert_eq!(found, whole);
    // A ray across the axis, and nothing to be seen.
    let across = Ray::new(Vec3::ZERO, Vec3::X, 20.0).unwrap();
    assert!(slabs(&across, &fog(), slices).is_empty());
    let nothing = Slices::new(Unshadowed, 10, Vec3::NEG_Z, [0.0; 2]);
    assert!(slabs(&ray, &fog(), nothing).is_empty());
    let forever = Slices::new(Unshadowed, 10, Vec3::NEG_Z, [0.0, f32::INFINITY]);
    assert!(slabs(&ray, &fog(), forever).is_empty());
    // From somewhere else than the eye on.
    let later = Slices::new(Unshadowed, 4, Vec3::NEG_Z, [6.0, 8.0]);
    let found = slabs(&ray, &fog(), later);
    assert_eq!((found.len(), found[0].start, found[3].end), (4, 6.0, 8.0));
}
