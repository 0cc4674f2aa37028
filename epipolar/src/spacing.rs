//! Where the bits of a texel lie along φ.

use glam::{DVec2, Vec2};

use crate::{Error, Ranges, Space, ViewVolume};

/// How the samples of φ are spread.
///
/// For the light in fog take [`Spacing::Angle`] for a light at a point, which puts many voxels
/// near the light, and [`Spacing::Airlight`] with the extinction of the fog for a directional
/// one: equal distances through thick fog would leave few voxels where most of its light comes
/// from. For surfaces take [`Spacing::Angle`] for both.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum Spacing {
    /// Equal steps of the angle at the light, which are equal steps of the
    /// equi-angular variable: in thin fog each bit stands for the same
    /// airlight, the inverse-square falloff included. For a directional light
    /// equal steps of the distance from the axis, which are equal steps of
    /// distance along every ray.
    #[default]
    Angle,
    /// Steps that are equal distances along the eye rays of the view, on
    /// average: rays of different α need different steps.
    Distance,
    /// Steps that carry equal airlight to the eye where nothing is in the
    /// way and scattering is isotropic, on average over the α of the view: as
    /// [`Spacing::Angle`], weighted with the extinction on the way.
    Airlight {
        /// Extinction of the medium, 1/m.
        sigma_t: f32,
    },
}

/// Rays over the range of α that are averaged.
const RAYS: u32 = 8;

/// Cells per bit in which a measure is tabulated.
const CELLS: u32 = 8;

/// Part of every measure that is uniform, so that no voxel becomes wider than 16
/// times the average for the sake of rays that are not representative.
const UNIFORM: f64 = 1.0 / 16.0;

/// The `bits + 1` bounds of the voxels along φ, as pairs; see
/// [`Phi`](crate::Phi).
pub(crate) fn bounds(
    space: &Space,
    view: &ViewVolume,
    ranges: &Ranges,
    spacing: Spacing,
    bits: u32,
) -> Result<Vec<Vec2>, Error> {
    let [low, high] = ranges.phi();
    let measure = match spacing {
        Spacing::Angle => None,
        Spacing::Distance if view.far == f64::INFINITY => {
            return Err(Error::bad_value(
                "the far bound of a view with samples at equal distances",
                view.far,
                "a finite distance",
            ));
        }
        Spacing::Airlight { sigma_t } if !(sigma_t >= 0.0 && sigma_t.is_finite()) => {
            return Err(Error::bad_value(
                "the extinction for equal airlight",
                sigma_t,
                "at least 0 and finite",
            ));
        }
        Spacing::Distance => Some(tabulate(space, view, ranges, bits, None)),
        Spacing::Airlight { sigma_t } => {
            let sigma_t = Some(f64::from(sigma_t));
            Some(tabulate(space, view, ranges, bits, sigma_t))
        }
    };
    let position = |share: f64| match &measure {
        None => low + share * (high - low),
        Some(cumulative) => low + quantile(cumulative, share) * (high - low),
    };
    Ok((0..=bits)
        .map(|i| position(f64::from(i) / f64::from(bits)))
        .map(|phi| {
            if space.is_directional() {
                DVec2::new(1.0, phi)
            } else {
                DVec2::new(phi.cos(), phi.sin().max(0.0))
            }
        })
        .map(|pair| pair.as_vec2())
        .collect())
}

/// The cumulative measure at equal steps of φ, from 0 to 1.
fn tabulate(
    space: &Space,
    view: &ViewVolume,
    ranges: &Ranges,
    bits: u32,
    sigma_t: Option<f64>,
) -> Vec<f64> {
    let cells = (CELLS * bits) as usize;
    let [low, high] = ranges.phi();
    let width = (high - low) / cells as f64;
    let mut density = vec![0.0; cells];
    let [alpha_low, alpha_high] = ranges.alpha();
    for ray in 0..RAYS {
        let share = (f64::from(ray) + 0.5) / f64::from(RAYS);
        let alpha = alpha_low + share * (alpha_high - alpha_low);
        let one: Vec<f64> = (0..cells)
            .map(|cell| {
                let [a, b] = [cell, cell + 1]
                    .map(|i| distance(space, alpha, low + i as f64 * width))
                    .map(|x| x.clamp(view.near, view.far));
                match sigma_t {
                    _ if !(a < b) => 0.0,
                    None => b - a,
                    Some(sigma_t) => airlight(space, alpha, low, width, cell, [a, b], sigma_t),
                }
            })
            .collect();
        let total: f64 = one.iter().sum();
        if total > 0.0 && total.is_finite() {
            for (sum, value) in density.iter_mut().zip(one) {
                *sum += value / total;
            }
        }
    }
    let total: f64 = density.iter().sum();
    let scale = if total > 0.0 {
        (1.0 - UNIFORM) / total
    } else {
        0.0
    };
    let mut sum = 0.0;
    let mut cumulative = vec![0.0];
    for value in density {
        sum += scale * value + UNIFORM / cells as f64;
        cumulative.push(sum);
    }
    cumulative.iter_mut().for_each(|value| *value /= sum);
    cumulative
}

/// The airlight of one cell of a ray, up to a factor of the ray: the part of
/// the cell that is in view, times the transmittance in its middle.
fn airlight(
    space: &Space,
    alpha: f64,
    low: f64,
    width: f64,
    cell: usize,
    [a, b]: [f64; 2],
    sigma_t: f64,
) -> f64 {
    let middle = low + (cell as f64 + 0.5) * width;
    if space.is_directional() {
        return (b - a) * (-sigma_t * 0.5 * (a + b)).exp();
    }
    let eye_light = f64::from(space.distance());
    // dx/d² = dφ / (D sin α): the inverse square of the light is in the width of the cell, and
    // the same for all cells of a ray but for a factor.
    //
    // x = D sin φ / sin(α + φ), d = D sin α / sin(α + φ); x + d ≥ D, and the
    // constant factor exp(−σ D) might underflow.
    let sine = (alpha + middle).sin();
    let way = eye_light * (middle.sin() + alpha.sin()) / sine;
    if !(sine > 0.0) {
        return 0.0;
    }
    width * (-sigma_t * (way - eye_light).max(0.0)).exp()
}

/// The distance along a ray at which it has reached φ.
fn distance(space: &Space, alpha: f64, phi: f64) -> f64 {
    if space.is_directional() {
        return if phi > 0.0 { phi / alpha.sin() } else { 0.0 };
    }
    let sine = (alpha + phi).sin();
    if alpha + phi < std::f64::consts::PI && sine > 0.0 {
        f64::from(space.distance()) * phi.sin() / sine
    } else {
        f64::INFINITY
    }
}

/// Where a cumulative measure reaches `share`, from 0 to 1 over the table.
fn quantile(cumulative: &[f64], share: f64) -> f64 {
    let cells = cumulative.len() - 1;
    let after = cumulative.partition_point(|value| *value < share);
    let cell = after.clamp(1, cells) - 1;
    let [a, b] = [cumulative[cell], cumulative[cell + 1]];
    // Every cell has its uniform part, so b > a.
    let within = ((share - a) / (b - a)).clamp(0.0, 1.0);
    (cell as f64 + within) / cells as f64
}
