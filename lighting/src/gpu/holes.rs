//! The holes of shadow maps on a GPU.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, Encode, Gpu, GpuMemory, INDEX_WGSL, Kernel, Workgroups};
use gpu_backend::{Backend, Buffer, Error};

use super::FACE;
use crate::shadow_map::{FillHoles, ShadowMapAtlas, pyramid_sides};

/// Invocations per workgroup of `holes.wgsl`.
const GROUP: u32 = 64;

pub(super) const HOLES: [&str; 3] = [INDEX_WGSL, FACE, include_str!("holes.wgsl")];

/// `Levels` of `holes.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Levels {
    pub(super) pictures: u32,
    pub(super) fine_side: u32,
    pub(super) coarse_side: u32,
    pub(super) fine_first: u32,
    pub(super) coarse_first: u32,
    pub(super) is_picture: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
}

impl<E: Encode> FillHoles for Gpu<E> {
    /// Two passes for each level.
    fn fill_holes(&self, maps: &mut ShadowMapAtlas<GpuMemory>, levels: u32) -> Result<(), Error> {
        let sides = pyramid_sides(maps.resolution(), levels);
        let texels = |side: u32| (side as usize).pow(2);
        let pictures = maps.depth().len() / texels(maps.resolution());
        if pictures == 0 || sides.len() == 1 {
            return Ok(());
        }
        let above: usize = sides[1..].iter().map(|side| pictures * texels(*side)).sum();
        let mut pyramid = self.zeros::<f32>(above)?;
        let mut pairs = Vec::new();
        let mut first = 0;
        for (level, pair) in sides.windows(2).enumerate() {
            let below = match level {
                0 => 0,
                _ => pictures * texels(pair[0]),
            };
            // No buffer of a device has more elements than a u32 counts.
            pairs.push(Levels {
                pictures: pictures as u32,
                fine_side: pair[0],
                coarse_side: pair[1],
                fine_first: first as u32,
                coarse_first: (first + below) as u32,
                is_picture: u32::from(level == 0),
                padding_a: 0,
                padding_b: 0,
            });
            first += below;
        }
        let mut pass = |entry, levels: Levels, side: u32| {
            self.dispatch(
                &Kernel {
                    label: "holes of shadow maps",
                    parts: &HOLES,
                    entry,
                    constants: &[],
                },
                &[&[
                    Argument::uniform(levels),
                    Argument::write(maps.depth_mut()),
                    Argument::write(&mut pyramid),
                ]],
                Workgroups::covering(pictures * texels(side), GROUP),
            )
        };
        for levels in &pairs {
            pass("pull", *levels, levels.coarse_side)?;
        }
        for levels in pairs.iter().rev() {
            pass("push", *levels, levels.fine_side)?;
        }
        Ok(())
    }
}
