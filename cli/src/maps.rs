//! How large shadow maps may be.

use lighting::Emitter;
use lighting::scene::Geometry;
use lighting::shadow_map::face_count;

use crate::format::count;

/// Memory that the shadow maps of all lights may take together.
pub(crate) const MAX_BYTES: u64 = 1 << 29;

/// The resolution asked for, or less if the maps of all `emitters` would take
/// more than 512 MiB; a note then.
pub(crate) fn affordable(
    asked: u32,
    geometry: &Geometry,
    emitters: &[Emitter],
    notes: &mut Vec<String>,
) -> u32 {
    let faces: u64 = emitters
        .iter()
        .map(|e| face_count(geometry, e) as u64)
        .sum();
    let side = side_within(MAX_BYTES, faces, asked);
    if side < asked {
        notes.push(format!(
            "shadow maps have {side} texels per side instead of {asked}, so that those of {} fit into 512 MiB",
            count(emitters.len(), "emitter")
        ));
    }
    side
}

/// The resolution asked for, or less if so many pictures of it would take more than `most`
/// bytes; 16 in any case.
pub(crate) fn side_within(most: u64, pictures: u64, asked: u32) -> u32 {
    let mut side = asked;
    while side > 16 && 4 * pictures * u64::from(side).pow(2) > most {
        side /= 2;
    }
    side
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gpu_backend::Cpu;
    use lighting::scene::Emission;
    use lighting::scene::procedural::Embedded;
    use lighting::shadow_map::{Casters, RenderShadowMap};

    use super::*;

    #[test]
    fn the_maps_of_many_lights_stay_within_their_memory() {
        let geometry = Geometry::new(&Embedded::Fence.build(1)).unwrap();
        let bounds = geometry.bounds();
        let centre = 0.5 * (bounds.min() + bounds.max());
        let light = Emitter::point(centre, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
        let mut notes = Vec::new();
        let one = std::slice::from_ref(&light);
        assert_eq!(affordable(1024, &geometry, one, &mut notes), 1024);
        assert!(notes.is_empty());
        let many = vec![light; 100];
        let side = affordable(1024, &geometry, &many, &mut notes);
        assert_eq!(notes.len(), 1);
        let backend = Cpu::new();
        let casters = Casters::upload(&backend, &geometry).unwrap();
        let map = backend.shadow_map(&casters, &many[0], side).unwrap();
        let total = 100 * map.bytes();
        assert!(total <= MAX_BYTES && 4 * total > MAX_BYTES, "{total}");
    }
}
