//! A march between shadow volumes in shaders.

use std::borrow::Borrow;

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::Part;
use gpu_backend::{Backend, Error};

use super::cells::{Cells, NOTHING};
use super::lit_volumes::{allowance, margin};
#[cfg(test)]
use super::search;
use super::{BuildLitVolumes, Hybrid, LitVolumes, ShadowVolumes, Spread};
use crate::gpu::scene::PicturesRecord;
use crate::gpu::{FACE, PLACE, PointSlot, VisibilitySlot};
use crate::shadow_map::ShadowMap;

/// `light_Hybrid` of `hybrid.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct HybridRecord {
    pub(crate) steps: u32,
    pub(crate) cell: u32,
    pub(crate) side: u32,
    pub(crate) by_span: u32,
    pub(crate) has_shadow: u32,
    pub(crate) has_light: u32,
    pub(crate) padding_a: u32,
    pub(crate) padding_b: u32,
}

/// The constants of `hybrid.wgsl`, as the CPU has them.
#[cfg(test)]
pub(crate) const CONSTANTS: [(&str, f64); 7] = [
    ("light_hybrid_PAST", search::PAST),
    ("light_hybrid_MOST_PICTURES", search::MOST_PICTURES as f64),
    ("light_hybrid_MOST_TURNS", search::MOST_TURNS as f64),
    ("light_hybrid_START", search::START as f64),
    ("light_hybrid_HALVINGS", super::HALVINGS as f64),
    ("light_hybrid_SHORT", super::asking::SHORT as f64),
    ("light_hybrid_LEAP", super::asking::LEAP as f64),
];

/// The search for volumes.
pub(crate) const SEARCH: &str = include_str!("search.wgsl");

/// Lookup of the values of volumes of either kind.
pub(super) const STORED: &str = "
fn light_hybrid_stored(of_light: bool, index: u32) -> f32 {
    if of_light {
        return light_hybrid_far[index];
    }
    return light_hybrid_near[index];
}
";

/// Lookup of the values of volumes of shadow, for shaders that look for no others.
pub(crate) const STORED_SHADOW: &str = "
fn light_hybrid_stored(of_light: bool, index: u32) -> f32 {
    return light_hybrid_near[index];
}
";

/// The record of the search, and what either kind of volumes holds.
pub(super) fn volumes_in_shader<'a>(
    (shadow, light): (
        Option<&'a ShadowVolumes<GpuMemory>>,
        Option<&'a LitVolumes<GpuMemory>>,
    ),
    steps: u32,
    spread: Spread,
) -> [Argument<'a>; 3] {
    let cells = cells((shadow, light));
    let record = HybridRecord {
        steps,
        cell: cells.map_or(0, |cells| cells.cell),
        side: cells.map_or(0, |cells| cells.side),
        by_span: u32::from(spread == Spread::Span),
        has_shadow: u32::from(shadow.is_some()),
        has_light: u32::from(light.is_some()),
        padding_a: 0,
        padding_b: 0,
    };
    let [near, far] = [shadow.map(|v| v.near()), light.map(|v| v.far())]
        .map(|values| values.map_or_else(|| Argument::table::<f32>(&[]), Argument::read));
    [Argument::uniform(record), near, far]
}

/// The cells of either kind of volumes.
pub(super) fn cells<'a>(
    (shadow, light): (
        Option<&'a ShadowVolumes<GpuMemory>>,
        Option<&'a LitVolumes<GpuMemory>>,
    ),
) -> Option<&'a Cells> {
    let cells = shadow.map(|volumes| &volumes.cells);
    cells.or(light.map(|volumes| &volumes.cells))
}

impl<P: Borrow<ShadowMap<GpuMemory>>> InShader<VisibilitySlot> for Hybrid<P, GpuMemory> {
    fn part() -> Part {
        let points = <ShadowMap<GpuMemory> as InShader<PointSlot>>::part();
        Part::new("light_hybrid")
            .glue::<PointSlot>(&points)
            .with(points)
            .uniform("light_hybrid", "light_Hybrid")
            .read("light_hybrid_near", "array<f32>")
            .read("light_hybrid_far", "array<f32>")
            .source(STORED)
            .source(SEARCH)
            .source(include_str!("hybrid.wgsl"))
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        InShader::<PointSlot>::constants(self.map())
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = InShader::<PointSlot>::arguments(self.map());
        let volumes = (self.volumes(), self.lit_volumes());
        arguments.extend(volumes_in_shader(volumes, self.steps(), self.spread()));
        arguments
    }
}

/// `Cells` of `far.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct CellsRecord {
    pub(crate) pictures: PicturesRecord,
    pub(crate) cell: u32,
    pub(crate) side: u32,
    pub(crate) margin: u32,
    pub(crate) level: u32,
    pub(crate) factor: f32,
    pub(crate) more: f32,
    pub(crate) most: f32,
    pub(crate) padding: u32,
}

/// The shader that finds how far light gets.
pub(crate) const FAR: [&str; 4] = [INDEX_WGSL, FACE, PLACE, include_str!("far.wgsl")];

impl<E: Encode> BuildLitVolumes for Gpu<E> {
    fn lit_volumes(&self, map: &ShadowMap<GpuMemory>) -> Result<LitVolumes<GpuMemory>, Error> {
        let cells = Cells::new(map.faces(), map.resolution());
        let mut far: GpuBuffer<f32> = self.zeros(cells.len())?;
        let [factor, more] = allowance(&map.faces()[0]);
        for level in 0..=cells.top() {
            let width = (cells.side >> level) as usize;
            self.dispatch(
                &Kernel {
                    label: "volumes of light",
                    parts: &FAR,
                    entry: if level == 0 { "find_far" } else { "raise_far" },
                    constants: &[],
                },
                &[&[
                    Argument::uniform(CellsRecord {
                        pictures: PicturesRecord::new(map.faces(), map.resolution()),
                        cell: cells.cell,
                        side: cells.side,
                        margin: margin(&cells),
                        level,
                        factor,
                        more,
                        most: NOTHING,
                        padding: 0,
                    }),
                    Argument::read(map.depth()),
                    Argument::write(&mut far),
                ]],
                Workgroups::covering(cells.pictures.len() * width * width, 64),
            )?;
        }
        Ok(LitVolumes { cells, far })
    }
}
