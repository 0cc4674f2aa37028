//! Environment light seen through fog.

use gpu_backend::Cpu;

use super::Table;
use super::fourier::{Fourier, LANES, Lanes};
use super::weights::Weights;
use crate::Error;

/// The fog between the eye and an environment, per colour channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fog {
    optical_distance: [f32; 3],
    albedo: [f32; 3],
}

impl Fog {
    /// `optical_distance` is `T = σ_t D` for an environment at the distance `D`,
    /// `albedo` is `σ_s/σ_t`.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless every T is finite and at least 0 and every
    /// albedo is from 0 to 1.
    pub fn new(optical_distance: [f32; 3], albedo: [f32; 3]) -> Result<Self, Error> {
        for t in optical_distance {
            if !(0.0..f32::INFINITY).contains(&t) {
                return Err(Error::bad_value(
                    "the optical distance of the environment",
                    t,
                    "a finite number, at least 0",
                ));
            }
        }
        for albedo in albedo {
            if !(0.0..=1.0).contains(&albedo) {
                return Err(Error::bad_value("the albedo", albedo, "0 to 1"));
            }
        }
        Ok(Self {
            optical_distance,
            albedo,
        })
    }
}

/// An environment of radiance `L` as it is seen through fog,
///
/// ```text
/// e^{−T} (L + σ_s/σ_t T ∫ N(γ) L dω)
/// ```
///
/// `map` holds `height` rows of `width` texels, evenly spaced in longitude and
/// in latitude, the first row about one pole and the last about the other. See
/// [`spread`] for accuracy and time, which is that of one call for each different
/// T. Values beyond the range of f32 are infinite.
///
/// # Errors
/// [`Error::BadValue`] as for [`spread`].
pub fn through_fog(
    cpu: &Cpu,
    fog: &Fog,
    map: &[[f32; 3]],
    width: usize,
    height: usize,
) -> Result<Vec<[f32; 3]>, Error> {
    check(map, width, height)?;
    let mut result = map.to_vec();
    let mut done = [false; 3];
    for first in 0..3 {
        if done[first] {
            continue;
        }
        let t = fog.optical_distance[first];
        let channels = (first..3).filter(|&channel| fog.optical_distance[channel] == t);
        let scatters = t > 0.0 && channels.clone().any(|channel| fog.albedo[channel] > 0.0);
        let blurred = if scatters {
            convolved(cpu, &Table::new(t)?, map, width, height)
        } else {
            vec![[0.0; 3]; map.len()]
        };
        let t = f64::from(t);
        for channel in channels {
            done[channel] = true;
            let scattered = t * f64::from(fog.albedo[channel]);
            for (texel, blurred) in result.iter_mut().zip(&blurred) {
                let light = f64::from(texel[channel]) + scattered * blurred[channel];
                texel[channel] = ((-t).exp() * light) as f32;
            }
        }
    }
    Ok(result)
}

/// `∫ N(γ) L(ω) dω` at the centre of every texel of a map of radiance, which is
/// taken as constant over each texel.
///
/// Every texel is weighted by the mean of N over it, also the one around the
/// centre, where N is infinite; weights are within 1.5e-4 of their true
/// value and sum to [`super::exact::total`] within 1e-4, so that an even
/// environment stays even. The rounding of the sum is below the
/// rounding of its result to f32 unless the map spans more than nine decades.
///
/// Rows are convolved by Fourier transforms: the time grows with
/// `height² width log(width)`, against `height² width²` for the sum as it
/// stands. A width that is not a power of two takes two to four times as long. The result does
/// not depend on the number of threads.
///
/// # Errors
/// [`Error::BadValue`] if the map is empty, if its length is not `width · height`,
/// if a texel is not finite, or if the map is higher than four times its width:
/// texels so wide would have to be cut in very many pieces.
pub fn spread(
    cpu: &Cpu,
    table: &Table,
    map: &[[f32; 3]],
    width: usize,
    height: usize,
) -> Result<Vec<[f32; 3]>, Error> {
    check(map, width, height)?;
    let result = convolved(cpu, table, map, width, height);
    Ok(result
        .into_iter()
        .map(|texel| texel.map(|value| value as f32))
        .collect())
}

fn check(map: &[[f32; 3]], width: usize, height: usize) -> Result<(), Error> {
    if map.is_empty() || width.checked_mul(height) != Some(map.len()) {
        return Err(Error::bad_value(
            "the number of texels of the environment",
            map.len() as f64,
            "the product of width and height, at least 1",
        ));
    }
    if height.div_ceil(4) > width {
        return Err(Error::bad_value(
            "the width of the environment",
            width as f64,
            "at least a quarter of its height",
        ));
    }
    match map.iter().flatten().find(|value| !value.is_finite()) {
        Some(&bad) => Err(Error::bad_value(
            "a texel of the environment",
            bad,
            "a finite number",
        )),
        None => Ok(()),
    }
}

fn convolved(
    cpu: &Cpu,
    table: &Table,
    map: &[[f32; 3]],
    width: usize,
    height: usize,
) -> Vec<[f64; 3]> {
    let convolution = Convolution::new(table, width, height);
    let spectra = convolution.spectra(cpu, map);
    // A row and its mirror image have the same weights.
    let rows = cpu.map(height.div_ceil(2), |row| convolution.rows(row, &spectra));
    let mut result = vec![[0.0; 3]; map.len()];
    for (row, [upper, lower]) in rows.into_iter().enumerate() {
        let mirrored = height - 1 - row;
        result[row * width..][..width].copy_from_slice(&upper);
        result[mirrored * width..][..width].copy_from_slice(&lower);
    }
    result
}

/// Convolution along rows, for all pairs of rows.
#[derive(Debug)]
struct Convolution<'a> {
    weights: Weights<'a>,
    width: usize,
    height: usize,
    fourier: Fourier,
}

impl<'a> Convolution<'a> {
    fn new(table: &'a Table, width: usize, height: usize) -> Self {
        // A row is a circle. Powers of two are transformed as they are, others
        // are laid out flat, with room for every difference of columns.
        let len = if width.is_power_of_two() {
            width
        } else {
            (2 * width - 1).next_power_of_two()
        };
        Self {
            weights: Weights::new(table, width, height),
            width,
            height,
            fourier: Fourier::new(len),
        }
    }

    /// Spectra of real rows are symmetric: half of them is enough.
    fn bins(&self) -> usize {
        self.fourier.len() / 2 + 1
    }

    /// The spectra of the three channels of all rows, by frequency and then by
    /// row.
    fn spectra(&self, cpu: &Cpu, map: &[[f32; 3]]) -> Vec<Lanes> {
        let rows = cpu.map(self.height, |row| {
            let mut data = vec![Lanes::default(); self.fourier.len()];
            for (slot, texel) in data.iter_mut().zip(&map[row * self.width..][..self.width]) {
                for (value, channel) in slot.re.iter_mut().zip(texel) {
                    *value = f64::from(*channel);
                }
            }
            self.fourier.transform(&mut data);
            data.truncate(self.bins());
            data
        });
        (0..self.bins())
            .flat_map(|bin| rows.iter().map(move |row| row[bin]))
            .collect()
    }

    /// A row of the result, and its mirror image.
    fn rows(&self, at: usize, spectra: &[Lanes]) -> [Vec<[f64; 3]>; 2] {
        let len = self.fourier.len();
        let mut sums = [(); 2].map(|()| vec![Lanes::default(); self.bins()]);
        let mut weights = vec![0.0; self.width / 2 + 1];
        let mut kernels = vec![Lanes::default(); len];
        for first in (0..self.height).step_by(2 * LANES) {
            let count = (self.height - first).min(2 * LANES);
            kernels.fill(Lanes::default());
            for index in 0..count {
                self.weights.row(at, first + index, &mut weights);
                self.lay_out(&weights, index, &mut kernels);
            }
            self.fourier.transform(&mut kernels);
            let [upper, lower] = &mut sums;
            let rows = spectra.chunks_exact(self.height);
            for (((upper, lower), row), kernel) in
                upper.iter_mut().zip(lower).zip(rows).zip(&kernels)
            {
                let mirrored = row[..self.height - first].iter().rev();
                for (index, (source, mirrored)) in
                    row[first..first + count].iter().zip(mirrored).enumerate()
                {
                    let factor = *part(kernel, index);
                    upper.add(factor, source);
                    lower.add(factor, mirrored);
                }
            }
        }
        sums.map(|sum| self.row_of(&sum))
    }

    /// Weights by the distance in columns as a periodic row: the one number
    /// `index` of those that are transformed together.
    ///
    /// Weights are even functions, so that their spectra are real: two of them
    /// are the real and the imaginary part of one transform.
    fn lay_out(&self, weights: &[f64], index: usize, kernels: &mut [Lanes]) {
        let len = kernels.len();
        for column in 0..self.width {
            let weight = weights[column.min(self.width - column)];
            *part_mut(&mut kernels[column], index) = weight;
            if len > self.width && column > 0 {
                *part_mut(&mut kernels[len - column], index) = weight;
            }
        }
    }

    /// Back from half a spectrum.
    fn row_of(&self, spectrum: &[Lanes]) -> Vec<[f64; 3]> {
        let len = self.fourier.len();
        // The inverse transform is the transform of the conjugate, whose other
        // half is the mirror image.
        let mut data = vec![Lanes::default(); len];
        for (bin, value) in spectrum.iter().enumerate() {
            data[bin] = Lanes {
                re: value.re,
                im: value.im.map(|im| -im),
            };
            if bin > 0 {
                data[len - bin] = *value;
            }
        }
        self.fourier.transform(&mut data);
        data[..self.width]
            .iter()
            .map(|value| [0, 1, 2].map(|channel| value.re[channel] / len as f64))
            .collect()
    }
}

/// Number `index` of the real numbers in there.
fn part(lanes: &Lanes, index: usize) -> &f64 {
    let half = if index.is_multiple_of(2) {
        &lanes.re
    } else {
        &lanes.im
    };
    &half[index / 2]
}

fn part_mut(lanes: &mut Lanes, index: usize) -> &mut f64 {
    let half = if index.is_multiple_of(2) {
        &mut lanes.re
    } else {
        &mut lanes.im
    };
    &mut half[index / 2]
}

#[cfg(test)]
mod tests;
