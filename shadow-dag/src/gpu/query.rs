//! Questions to shadows on a GPU.

use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, Kernel, Workgroups,
};
use gpu_backend::{Buffer, Element};

use super::{DagRecord, EXTENT, PACKED, PLAIN, POINT, RAY, SPACE, SpaceRecord};
use crate::error::same_length;
use crate::query::places;
use crate::{Error, FilterSize, Form, Query, RayRecord, ResidentDag};

/// Invocations per workgroup.
const GROUP: u32 = 64;

/// All parts of the shaders, by the form of the nodes.
pub(super) const fn query(form: Form) -> [&'static str; 5] {
    [
        INDEX_WGSL,
        POINT,
        nodes(form),
        EXTENT,
        include_str!("query.wgsl"),
    ]
}

pub(super) const fn rays(form: Form) -> [&'static str; 6] {
    [
        INDEX_WGSL,
        POINT,
        nodes(form),
        SPACE,
        RAY,
        include_str!("rays.wgsl"),
    ]
}

const fn nodes(form: Form) -> &'static str {
    match form {
        Form::Plain => PLAIN,
        Form::Packed => PACKED,
    }
}

/// Uniforms of `query.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct QueryParameters {
    pub(super) dag: DagRecord,
    pub(super) count: u32,
    pub(super) width: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
}

/// Uniforms of `rays.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct RayParameters {
    pub(super) dag: DagRecord,
    pub(super) space: SpaceRecord,
    pub(super) count: u32,
    pub(super) places: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
}

impl RayParameters {
    fn new(dag: &ResidentDag<GpuMemory>, count: usize, places: usize) -> Self {
        Self {
            dag: DagRecord::new(dag),
            space: SpaceRecord::of(dag),
            // More are refused by the dispatch.
            count: count as u32,
            places: places as u32,
            padding_a: 0,
            padding_b: 0,
        }
    }
}

/// Runs an entry point of `query.wgsl`.
fn ask<E: Encode, Q: Element, A: Element>(
    gpu: &Gpu<E>,
    entry: &'static str,
    dag: &ResidentDag<GpuMemory>,
    width: u32,
    questions: &GpuBuffer<Q>,
    answers: &mut GpuBuffer<A>,
) -> Result<(), Error> {
    same_length("places for answers", questions.len(), answers.len())?;
    let parameters = QueryParameters {
        dag: DagRecord::new(dag),
        count: questions.len() as u32,
        width,
        padding_a: 0,
        padding_b: 0,
    };
    gpu.dispatch(
        &Kernel {
            label: entry,
            parts: &query(dag.form()),
            entry,
            constants: &[],
        },
        &[&[
            Argument::uniform(parameters),
            Argument::read(dag.words()),
            Argument::write(answers),
            Argument::read(questions),
        ]],
        Workgroups::covering(questions.len(), GROUP),
    )?;
    Ok(())
}

impl<E: Encode> Query for Gpu<E> {
    fn is_lit(
        &self,
        dag: &ResidentDag<GpuMemory>,
        voxels: &GpuBuffer<[i32; 4]>,
        lit: &mut GpuBuffer<u32>,
    ) -> Result<(), Error> {
        ask(self, "is_lit", dag, 1, voxels, lit)
    }

    fn count_lit(
        &self,
        dag: &ResidentDag<GpuMemory>,
        size: FilterSize,
        voxels: &GpuBuffer<[i32; 4]>,
        counts: &mut GpuBuffer<u32>,
    ) -> Result<(), Error> {
        ask(self, "count_lit", dag, size.width(), voxels, counts)
    }

    fn filter(
        &self,
        dag: &ResidentDag<GpuMemory>,
        size: FilterSize,
        voxels: &GpuBuffer<[i32; 4]>,
        lit: &mut GpuBuffer<f32>,
    ) -> Result<(), Error> {
        ask(self, "filter_voxels", dag, size.width(), voxels, lit)
    }

    fn filter_bilinear(
        &self,
        dag: &ResidentDag<GpuMemory>,
        size: FilterSize,
        positions: &GpuBuffer<[f32; 4]>,
        lit: &mut GpuBuffer<f32>,
    ) -> Result<(), Error> {
        ask(self, "filter_bilinear", dag, size.width(), positions, lit)
    }

    fn depth(
        &self,
        dag: &ResidentDag<GpuMemory>,
        texels: &GpuBuffer<[u32; 2]>,
        depths: &mut GpuBuffer<u32>,
    ) -> Result<(), Error> {
        ask(self, "depth", dag, 1, texels, depths)
    }

    fn visibility(
        &self,
        dag: &ResidentDag<GpuMemory>,
        boxes: &GpuBuffer<[[i32; 4]; 2]>,
        seen: &mut GpuBuffer<u32>,
    ) -> Result<(), Error> {
        ask(self, "visibility", dag, 1, boxes, seen)
    }

    fn lit_length(
        &self,
        dag: &ResidentDag<GpuMemory>,
        rays: &GpuBuffer<RayRecord>,
        lengths: &mut GpuBuffer<f32>,
    ) -> Result<(), Error> {
        same_length("places for lit lengths", rays.len(), lengths.len())?;
        self.dispatch(
            &Kernel {
                label: "lit lengths",
                parts: &self::rays(dag.form()),
                entry: "lit_length",
                constants: &[],
            },
            &[&[
                Argument::uniform(RayParameters::new(dag, rays.len(), 0)),
                Argument::read(dag.words()),
                Argument::read(rays),
                Argument::write(lengths),
            ]],
            Workgroups::covering(rays.len(), GROUP),
        )?;
        Ok(())
    }

    fn lit_intervals(
        &self,
        dag: &ResidentDag<GpuMemory>,
        rays: &GpuBuffer<RayRecord>,
        intervals: &mut GpuBuffer<[f32; 2]>,
        counts: &mut GpuBuffer<u32>,
    ) -> Result<(), Error> {
        let places = places(rays.len(), intervals.len(), counts.len())?;
        self.dispatch(
            &Kernel {
                label: "lit intervals",
                parts: &self::rays(dag.form()),
                entry: "lit_intervals",
                constants: &[],
            },
            &[&[
                Argument::uniform(RayParameters::new(dag, rays.len(), places)),
                Argument::read(dag.words()),
                Argument::read(rays),
                Argument::write(counts),
                Argument::write(intervals),
            ]],
            Workgroups::covering(rays.len(), GROUP),
        )?;
        Ok(())
    }
}
