//! Coordinates in double precision, moved to where single precision is enough.

use glam::{DVec3, Vec3};

use super::LoadOptions;
use super::limits::Notes;

/// Coordinates are moved if they are farther out than this many times their
/// extent: four of the 24 bits of an `f32` are lost there.
const FAR: f64 = 16.0;

/// Takes a file's coordinates to metres with +Y up and, if single precision
/// would move one of them there, to the origin. Returns by how much they were
/// moved.
pub(super) fn place(
    positions: &[DVec3],
    options: &LoadOptions,
    notes: &mut Notes,
) -> (Vec<Vec3>, DVec3) {
    let rotation = options.unit * options.up.rotation();
    let turned = |position: &DVec3| rotation * *position;
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut is_exact = true;
    for position in positions.iter().map(turned) {
        if position.is_finite() {
            min = min.min(position);
            max = max.max(position);
            is_exact &= position.as_vec3().as_dvec3() == position;
        }
    }
    let extent = (max - min).max_element();
    let farthest = min.abs().max(max.abs()).max_element();
    let mut offset = DVec3::ZERO;
    if !is_exact && farthest.is_finite() && farthest > FAR * extent {
        // A whole number of metres loses nothing and reads well.
        offset = (0.5 * (min + max)).round();
        notes.add(format!(
            "the scene was moved by {offset} m to the origin, where single precision is enough"
        ));
    }
    // Minus zero would be another value for no reason.
    let placed = |position: &DVec3| (turned(position) - offset + DVec3::ZERO).as_vec3();
    (positions.iter().map(placed).collect(), offset)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::UpAxis;

    fn placed(positions: &[DVec3], options: &LoadOptions) -> (Vec<Vec3>, DVec3) {
        place(positions, options, &mut Notes::default())
    }

    #[test]
    fn far_coordinates_keep_their_differences() {
        let corner = DVec3::new(500_000.123, 0.0, 4_649_776.25);
        let positions = [corner, corner + 0.001, corner + DVec3::new(20.0, 1.0, 3.0)];
        let (placed, offset) = placed(&positions, &LoadOptions::default());
        assert_eq!(offset, offset.round());
        for (position, placed) in positions.iter().zip(&placed) {
            assert!((*position - offset - placed.as_dvec3()).length() < 1e-6);
        }
        assert!(placed[0].length() < 20.0);
    }

    #[test]
    fn coordinates_that_f32_holds_stay_where_they_are() {
        let far = DVec3::splat(1_048_576.5);
        for positions in [
            vec![far, far + 1.0],
            vec![DVec3::splat(0.1), DVec3::splat(1.3)],
            vec![DVec3::NAN, far],
            vec![DVec3::INFINITY],
            vec![],
        ] {
            let (placed, offset) = placed(&positions, &LoadOptions::default());
            assert_eq!(offset, DVec3::ZERO, "{positions:?}");
            assert_eq!(placed.len(), positions.len());
        }
    }

    #[test]
    fn unit_and_axis_come_before_the_offset() {
        let options = LoadOptions {
            unit: 0.01,
            up: UpAxis::Z,
            ..LoadOptions::default()
        };
        let far = DVec3::new(100.0, 0.0, 1e9);
        let (placed, offset) = placed(&[far, far + DVec3::Y], &options);
        assert_eq!(offset, DVec3::new(1.0, 1e7, 0.0));
        assert!((placed[1] - placed[0] + 0.01 * Vec3::Z).length() < 1e-6);
    }
}
