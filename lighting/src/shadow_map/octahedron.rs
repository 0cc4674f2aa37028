//! Directions as points of a square: the octahedron |x| + |y| + |z| = 1, unfolded.
//!
//! Based on: Cigolle, Donow, Evangelakos, Mara, McGuire, Meyer, A Survey of
//! Efficient Representations for Independent Unit Vectors, JCGT 2014.
//!
//! A hemisphere is the half of the octahedron with z ≥ 0; it is a square that stands on a
//! corner and is turned to fill the picture. A sphere has the other half in the corners of the
//! picture. The solid angle of a texel varies by a factor of 5.2 over either.

use glam::Vec3;

use crate::scene::raster::Face;

/// Takes the place of the number of faces for a light that has one picture of the hemisphere
/// around the forward direction of its face.
pub(crate) const HEMISPHERE: u32 = 0x100;

/// The same for a picture of the sphere.
pub(crate) const SPHERE: u32 = 0x101;

/// Column and row, from 0 to the resolution, at which a picture of this kind shows the
/// direction `v`; `None` behind a hemisphere, and for a vector of length 0.
#[inline]
pub(super) fn octahedral(face: &Face, kind: u32, resolution: u32, v: Vec3) -> Option<[f32; 2]> {
    let (x, y, z) = (v.dot(face.right), v.dot(face.up), v.dot(face.forward));
    let sum = x.abs() + y.abs() + z.abs();
    if !(sum > 0.0) || (kind == HEMISPHERE && z <= 0.0) {
        return None;
    }
    let (p, q) = (x / sum, y / sum);
    let (a, b) = if kind == HEMISPHERE {
        (p + q, p - q)
    } else if z >= 0.0 {
        (p, q)
    } else {
        ((1.0 - q.abs()).copysign(p), (1.0 - p.abs()).copysign(q))
    };
    let n = resolution as f32;
    let inside = |value: f32| (0.5 * n * (1.0 + value)).clamp(0.0, n);
    Some([inside(a), inside(b)])
}

/// Texels per radian on the axes of the frame, where texels have the smallest solid angle. A
/// texel in the unit direction v has |v|₁³ times that solid angle.
pub(crate) fn texels_per_radian(kind: u32, resolution: u32) -> f32 {
    let area: f32 = if kind == HEMISPHERE { 2.0 } else { 4.0 };
    resolution as f32 / area.sqrt()
}

/// The square root of that factor, for a v of any length: how much wider texels are than on an
/// axis.
#[inline]
pub(super) fn width(face: &Face, v: Vec3) -> f32 {
    let sum = [face.right, face.up, face.forward].map(|axis| v.dot(axis).abs());
    let ratio = sum.iter().sum::<f32>() / v.length();
    ratio * ratio.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::raster::Rays;

    #[test]
    fn directions_near_each_other_are_near_and_fill_the_square() {
        let face = Face {
            origin: Vec3::ZERO,
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::Z,
            rays: Rays::Central { tan: 1.0 },
        };
        for kind in [HEMISPHERE, SPHERE] {
            let mut seen = vec![0_u32; 16 * 16];
            for i in 0..200_000 {
                // Vogel's spiral over the sphere.
                let z = 1.0 - (2 * i + 1) as f32 / 200_000.0;
                let turn = i as f32 * 2.399_963_1;
                let flat = (1.0 - z * z).sqrt();
                let v = Vec3::new(flat * turn.cos(), flat * turn.sin(), z);
                let found = octahedral(&face, kind, 16, 3.0 * v);
                assert_eq!(found.is_some(), kind == SPHERE || z > 0.0);
                let Some([column, row]) = found else { continue };
                let texel = [column, row].map(|at| (at as usize).min(15));
                seen[16 * texel[1] + texel[0]] += 1;
                // What is a hundredth of a radian away is at most a quarter of
                // a texel away; seams of the sphere aside.
                let near = (v + 0.01 * v.any_orthonormal_vector()).normalize();
                if let Some([x, y]) = octahedral(&face, kind, 16, near)
                    && v.abs().min_element() > 0.02
                {
                    assert!((x - column).abs().max((y - row).abs()) < 0.3, "{v}");
                }
            }
            let (low, high) = (seen.iter().min().unwrap(), seen.iter().max().unwrap());
            assert!(
                *low > 0 && f64::from(*high) < 6.0 * f64::from(*low),
                "{low} {high}"
            );
        }
        assert!(octahedral(&face, SPHERE, 16, Vec3::ZERO).is_none());
        assert!(octahedral(&face, SPHERE, 16, Vec3::NAN).is_none());
        // All texels together are the sphere, or half of it.
        for kind in [HEMISPHERE, SPHERE] {
            let texel = texels_per_radian(kind, 1).powi(-2);
            let mut sum = 0.0;
            for i in 0..200_000 {
                let z = 1.0 - (2 * i + 1) as f32 / 200_000.0;
                let turn = (i as f32 * 0.618_034).fract() * std::f32::consts::TAU;
                let v = (1.0 - z * z).sqrt() * Vec3::new(turn.cos(), turn.sin(), 0.0) + z * Vec3::Z;
                if kind == SPHERE || z > 0.0 {
                    // The share of the square that this direction stands for.
                    sum +=
                        4.0 * std::f32::consts::PI / 200_000.0 / (texel * width(&face, v).powi(2));
                }
            }
            assert!((sum - 1.0).abs() < 0.01, "{kind}: {sum}");
        }
    }
}
