//! The steps that fill a picture from samples.

use gpu_backend::{Backend, BufferOf, Cpu, Error, Host, Memory};

use super::Choice;
use super::choice::NONE;
use super::grid::Filter;
use super::resemblance::Seen;
use crate::Ray;
use crate::gather::check_lengths;

/// A choice in the memory of a backend, with what it takes to fill the picture.
#[derive(Debug)]
pub struct Filling<'a, M: Memory> {
    pub(super) choice: &'a Choice,
    /// The rays of the whole picture.
    pub(super) rays: &'a M::Buffer<Ray>,
    pub(super) planes: M::Buffer<[f32; 4]>,
    pub(super) of_samples: M::Buffer<u32>,
    pub(super) of_pixels: M::Buffer<u32>,
}

impl<'a, M: Memory> Filling<'a, M> {
    /// Copies a choice to a backend. `rays` must be those of the whole picture.
    ///
    /// # Errors
    /// Those of [`Backend::upload`]; [`Error::LengthMismatch`] if the rays are not those of the
    /// picture.
    pub fn upload<B>(
        backend: &B,
        choice: &'a Choice,
        rays: &'a M::Buffer<Ray>,
    ) -> Result<Self, Error>
    where
        B: Backend<Memory = M>,
    {
        use gpu_backend::Buffer;

        if rays.len() != choice.planes.len() {
            return Err(Error::LengthMismatch {
                what: "the rays of a picture",
                expected: choice.planes.len(),
                actual: rays.len(),
            });
        }
        Ok(Self {
            choice,
            rays,
            planes: backend.upload(&choice.planes)?,
            of_samples: backend.upload(&choice.of_samples)?,
            of_pixels: backend.upload(&choice.of_pixels)?,
        })
    }
}

/// A backend that fills pictures from samples. Every backend of this workspace does.
pub trait FillPicture: Backend {
    /// Adds to the first three components of `radiance[i]` the light of pixel i, from
    /// `gathered`, which is the light of the [rays](Choice::rays) of a choice.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if there is not one entry of `gathered` for each ray, or of
    /// radiance for each pixel; nothing is written then.
    fn fill_picture(
        &self,
        filling: &Filling<'_, Self::Memory>,
        gathered: &BufferOf<Self, [f32; 4]>,
        radiance: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Error>;
}

pub(super) fn check(choice: &Choice, gathered: usize, radiance: usize) -> Result<(), Error> {
    if gathered != choice.rays().len() {
        return Err(Error::LengthMismatch {
            what: "the light of the rays of a choice",
            expected: choice.rays().len(),
            actual: gathered,
        });
    }
    check_lengths(choice.grid.pixels(), radiance)
}

/// A weighted mean.
#[derive(Default)]
struct Mean {
    sum: [f32; 3],
    weight: f32,
}

impl Mean {
    fn add(&mut self, light: [f32; 4], weight: f32) {
        for (sum, light) in self.sum.iter_mut().zip(light) {
            *sum += weight * light;
        }
        self.weight += weight;
    }

    fn value(&self) -> [f32; 3] {
        self.sum.map(|sum| sum / self.weight)
    }
}

fn add(pixel: &mut [f32; 4], light: [f32; 3]) {
    for (sum, light) in pixel.iter_mut().zip(light) {
        *sum += light;
    }
}

impl Filling<'_, Host> {
    fn seen(&self) -> Seen<'_> {
        Seen {
            rays: self.rays,
            planes: &self.planes,
            matters: self.choice.grid.filter == Filter::Bilateral,
        }
    }

    /// Adds to each sample the mean over the subsets around it.
    fn join_subsets(&self, cpu: &Cpu, gathered: &[[f32; 4]], samples: &mut [[f32; 4]]) {
        let grid = &self.choice.grid;
        let seen = self.seen();
        let columns = grid.samples[0] as usize;
        let n = grid.window;
        let share = 1.0 / (n * n) as f32;
        cpu.for_each_chunk(samples, 256, |first, chunk| {
            for (sample, out) in (first..).zip(chunk) {
                let own = self.of_samples[sample];
                if own != NONE {
                    let [r, g, b, _] = gathered[own as usize];
                    add(out, [r, g, b]);
                    continue;
                }
                let place = [sample % columns, sample / columns].map(|i| i as u32);
                let pixel = grid.pixel(place);
                let mut sum = [0.0; 4];
                for b in 0..n {
                    for a in 0..n {
                        let mut mean = Mean::default();
                        grid.for_each_beside(place, [a, b], |sample, weight| {
                            let weight = weight * seen.resemblance(pixel, grid.pixel(sample));
                            mean.add(gathered[grid.slot(sample)], weight);
                        });
                        add(&mut sum, mean.value());
                    }
                }
                add(out, [sum[0], sum[1], sum[2]].map(|sum| share * sum));
            }
        });
    }

    /// Adds to each pixel the mean of the samples around it.
    fn fill_between(
        &self,
        cpu: &Cpu,
        [gathered, samples]: [&[[f32; 4]]; 2],
        radiance: &mut [[f32; 4]],
    ) {
        let grid = &self.choice.grid;
        let seen = self.seen();
        let columns = grid.size[0] as usize;
        cpu.for_each_chunk(radiance, 256, |first, chunk| {
            for (pixel, out) in (first..).zip(chunk) {
                let own = self.of_pixels[pixel];
                if own != NONE {
                    let [r, g, b, _] = gathered[own as usize];
                    add(out, [r, g, b]);
                    continue;
                }
                let place = [pixel % columns, pixel / columns].map(|i| i as u32);
                let mut mean = Mean::default();
                grid.for_each_between(place, |[x, y], weight| {
                    let weight = weight * seen.resemblance(pixel, grid.pixel([x, y]));
                    let sample = y as usize * grid.samples[0] as usize + x as usize;
                    mean.add(samples[sample], weight);
                });
                add(out, mean.value());
            }
        });
    }
}

impl FillPicture for Cpu {
    fn fill_picture(
        &self,
        filling: &Filling<'_, Host>,
        gathered: &Vec<[f32; 4]>,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check(filling.choice, gathered.len(), radiance.len())?;
        let grid = &filling.choice.grid;
        if grid.block == 1 {
            filling.join_subsets(self, gathered, radiance);
            return Ok(());
        }
        if grid.window == 1 {
            filling.fill_between(self, [gathered, gathered], radiance);
            return Ok(());
        }
        let mut samples = self.zeros::<[f32; 4]>(grid.sample_count())?;
        filling.join_subsets(self, gathered, &mut samples);
        filling.fill_between(self, [gathered, &samples], radiance);
        Ok(())
    }
}
