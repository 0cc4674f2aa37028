//! How many voxels and texels so many lights need.
//!
//! Based on: Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013, section 3.2:
//! no axis should be sampled finer than the worst of the others makes worth while. They
//! took 128 for all; this is why, and what fewer lights and small pictures need.

/// Voxels along an axis, at least: those of one word of φ.
const LEAST: u32 = 32;

/// The same, at most: what a hard shadow by itself needs (the paper's section 3.2).
const MOST: u32 = 512;

/// Voxels per square root of the number of lights.
///
/// With n points on a light, independent of each other, the image errs by about 0.9/n of
/// its mean (measured with exact shadows, 16 to 512 points of a low-discrepancy lattice).
/// A voxel moves an end of a lit part by as much as half of it, evenly distributed: by
/// 1/(R √12) of the ray for R voxels along it. The spaces of the lights are turned
/// against each other, so these errors are independent, and k ends of each of n lights
/// leave √(k / (12 n)) / R. Their share is a third of the points' (a twentieth of the sum
/// of the squares) at
///
/// ```text
/// R = 3 √(k / 12) / 0.9 · √n
/// ```
///
/// which is 3.3 √n for k = 12 ends, a ray through six shadows. The light of a ray is not
/// even along it: twice as many keep that share where it is twice the mean.
const PER_ROOT: f64 = 6.7;

/// The numbers of voxels along the axes that are worth while, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// Voxels along α, θ and φ. Shadow maps have as many texels along each side as φ has
    /// bits.
    pub voxels: [u32; 3],
    /// The reason, in a sentence.
    pub reason: String,
}

/// What an area light of `lights` points needs, seen in a picture of `size` pixels.
///
/// The number of lights bounds all axes, see the constant above: 6.7 √n, a multiple of
/// 32 from 32 to 512. The view bounds two of them. Epipolar lines meet the border of the
/// picture, whose 2 (width + height) pixels tell as many of them apart at most: no more
/// θ. Along one of them no more than √(width² + height²) pixels lie: no more α. Both are
/// from 1 on. Where along a ray shadows lie, which φ tells, does not depend on pixels.
pub fn planned(lights: u32, size: [u32; 2]) -> Planned {
    let wanted = PER_ROOT * f64::from(lights.max(1)).sqrt();
    let side = (wanted.ceil() as u32)
        .next_multiple_of(LEAST)
        .clamp(LEAST, MOST);
    let [width, height] = size.map(f64::from);
    let lines = (2.0 * (width + height)).clamp(1.0, side.into());
    let along = width.hypot(height).ceil().clamp(1.0, side.into());
    let (alpha, theta) = (along as u32, lines as u32);
    let mut reason = format!(
        "{side} voxels along an axis add little to the error that {lights} points on a light have"
    );
    if alpha < side {
        reason += &format!("; the picture has {alpha} pixels along a line through the light");
    }
    if theta < side {
        reason += &format!(" and {theta} such lines");
    }
    Planned {
        voxels: [alpha, theta, side],
        reason,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxelized::Resolution;

    #[test]
    fn resolutions_rise_with_the_lights_and_are_legal_whatever_the_picture() {
        let sides = [1, 16, 64, 128, 256, 1024, 4096, u32::MAX].map(|lights| {
            let Planned { voxels, reason } = planned(lights, [960, 540]);
            assert!(reason.contains(&lights.to_string()), "{reason}");
            let [alpha, theta, phi] = voxels;
            assert_eq!([alpha, theta], [phi; 2]);
            phi
        });
        assert_eq!(sides, [32, 32, 64, 96, 128, 224, 448, 512]);
        for size in [[0, 0], [1, 1], [16, 9], [u32::MAX, 3], [u32::MAX; 2]] {
            for lights in [0, 1, 256, u32::MAX] {
                let [alpha, theta, phi] = planned(lights, size).voxels;
                assert!(Resolution::new(alpha, theta, phi).is_ok());
                assert!(alpha <= phi && theta <= phi);
            }
        }
    }

    #[test]
    fn small_pictures_need_fewer_lines_and_fewer_voxels_along_them() {
        let Planned { voxels, reason } = planned(256, [16, 9]);
        assert_eq!(voxels, [19, 50, 128]);
        assert!(
            reason.contains("19 pixels") && reason.contains("50 such lines"),
            "{reason}"
        );
        assert!(!planned(256, [160, 90]).reason.contains("pixels"));
    }
}
