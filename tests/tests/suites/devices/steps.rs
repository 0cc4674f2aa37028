//! The steps of the crates below the methods, each on buffers that are there before.

use std::error::Error;

use airlight::{EvaluateAirlight, PhaseFunction, Quadrature, Segment};
use epipolar::{Lattice, Light, Locate, Resolution, Space, Spacing, ViewVolume};
use glam::Vec3;
use gpu_backend::gpu::{Encode, Gpu, GpuBuffer, GpuMemory, Queued};
use gpu_backend::{Backend, Cpu};
use shadow_dag::{Builder, DepthMap, FilterSize, RayRecord, ResidentDag, Slices};
use transmittance::{
    BlockerSegment, BuildMap, CaptureSegments, Filter, Lists, Order, Packed, QueryMap, Receiver,
    SegmentLists, Stream, TransmittanceMap,
};
use voxel_shadow::{
    AtlasGrid, AtlasMap, BuildAtlas, BuildGrid, Grid, IndexMap, LitInterval, RectifyTriangles,
    Sampling, ShadowVolume, Weights,
};

/// A step by its name, and its error.
pub(super) type Outcome = (&'static str, Result<(), Box<dyn Error>>);

fn outcome<E: Error + 'static>(name: &'static str, result: Result<(), E>) -> Outcome {
    (name, result.map_err(Box::from))
}

/// Everything that steps read and write.
pub(super) struct Steps {
    airlight: Airlight,
    voxels: Voxels,
    dag: Dag,
    curves: Curves,
}

impl Steps {
    pub(super) fn new(gpu: &Gpu<Queued>) -> Self {
        Self {
            airlight: Airlight::new(gpu),
            voxels: Voxels::new(gpu),
            dag: Dag::new(gpu),
            curves: Curves::new(gpu),
        }
    }

    /// Runs all of them.
    pub(super) fn run<E: Encode>(&mut self, gpu: &Gpu<E>) -> Vec<Outcome> {
        let mut outcomes = vec![self.airlight.run(gpu)];
        outcomes.extend(self.voxels.run(gpu));
        outcomes.extend(self.dag.run(gpu));
        outcomes.extend(self.curves.run(gpu));
        outcomes
    }
}

struct Airlight {
    evaluator: Quadrature,
    segments: GpuBuffer<Segment>,
    airlight: GpuBuffer<f32>,
}

impl Airlight {
    fn new(gpu: &Gpu<Queued>) -> Self {
        let segment = Segment {
            x: 0.0,
            s: -1.0,
            h: 0.5,
            length: 3.0,
        };
        Self {
            evaluator: Quadrature::with_tolerance(PhaseFunction::Isotropic, 1e-2).unwrap(),
            segments: gpu.upload(&[segment; 3]).unwrap(),
            airlight: gpu.zeros(3).unwrap(),
        }
    }

    fn run<E: Encode>(&mut self, gpu: &Gpu<E>) -> Outcome {
        let evaluated =
            gpu.evaluate_airlight(&self.evaluator, 0.1, &self.segments, &mut self.airlight);
        outcome("evaluate_airlight", evaluated)
    }
}

struct Voxels {
    lattice: Lattice,
    triangles: GpuBuffer<[Vec3; 3]>,
    map: IndexMap<GpuMemory>,
    grid: Grid<GpuMemory>,
    atlas_map: AtlasMap<GpuMemory>,
    atlas: AtlasGrid<GpuMemory>,
    weights: Weights,
    points: GpuBuffer<[f32; 4]>,
    places: GpuBuffer<[f32; 4]>,
    shares: GpuBuffer<f32>,
    intervals: GpuBuffer<LitInterval>,
    counts: GpuBuffer<u32>,
}

impl Voxels {
    fn new(gpu: &Gpu<Queued>) -> Self {
        let eye = Vec3::new(0.2, 1.7, 8.0);
        let light = Light::point(Vec3::new(1.0, 3.0, -2.0)).unwrap();
        let view = ViewVolume::perspective(Vec3::NEG_Z, Vec3::Y, [0.9, 0.6], 0.0, 20.0).unwrap();
        let resolution = Resolution::new(8, 8, 32).unwrap();
        let space = Space::new(light, eye).unwrap();
        Self {
            lattice: Lattice::new(space, &view, resolution, Spacing::Angle).unwrap(),
            triangles: gpu.upload(&[[Vec3::ZERO, Vec3::X, Vec3::Y]]).unwrap(),
            map: IndexMap::new(gpu, resolution).unwrap(),
            grid: Grid::new(gpu, resolution).unwrap(),
            atlas_map: AtlasMap::new(gpu, resolution, 2).unwrap(),
            atlas: AtlasGrid::new(gpu, resolution, 2).unwrap(),
            weights: Weights::new(&[1.0; 32]).unwrap(),
            points: gpu.upload(&[[0.1, 0.2, -1.0, 5.0]; 2]).unwrap(),
            places: gpu.zeros(2).unwrap(),
            shares: gpu.zeros(2).unwrap(),
            intervals: gpu.zeros(8).unwrap(),
            counts: gpu.zeros(2).unwrap(),
        }
    }

    fn run<E: Encode>(&mut self, gpu: &Gpu<E>) -> Vec<Outcome> {
        use voxel_shadow::Query;
        let (lattice, points, shares) = (&self.lattice, &self.points, &mut self.shares);
        let mut outcomes = vec![
            outcome("locate", gpu.locate(lattice, points, &mut self.places)),
            outcome(
                "rectify_triangles",
                gpu.rectify_triangles(lattice, &self.triangles, &mut self.map),
            ),
            outcome("voxelise", gpu.voxelise(&self.map, &mut self.grid)),
            outcome("extrude", gpu.extrude(&mut self.grid)),
            outcome(
                "build_atlas",
                gpu.build_atlas(&self.atlas_map, 2, &mut self.atlas),
            ),
        ];
        let volume = ShadowVolume::new(lattice, &self.grid, Sampling::UNBIASED).unwrap();
        outcomes.extend([
            outcome("visibility", gpu.visibility(&volume, points, shares)),
            outcome("lit_fraction", gpu.lit_fraction(&volume, points, shares)),
            outcome(
                "weighted_sum",
                gpu.weighted_sum(&volume, &self.weights, points, shares),
            ),
            outcome(
                "lit_intervals",
                gpu.lit_intervals(&volume, points, &mut self.intervals, &mut self.counts),
            ),
        ]);
        outcomes
    }
}

struct Dag {
    dag: ResidentDag<GpuMemory>,
    voxels: GpuBuffer<[i32; 4]>,
    texels: GpuBuffer<[u32; 2]>,
    boxes: GpuBuffer<[[i32; 4]; 2]>,
    positions: GpuBuffer<[f32; 4]>,
    rays: GpuBuffer<RayRecord>,
    words: GpuBuffer<u32>,
    shares: GpuBuffer<f32>,
    intervals: GpuBuffer<[f32; 2]>,
}

impl Dag {
    fn new(gpu: &Gpu<Queued>) -> Self {
        let resolution = shadow_dag::Resolution::new(8).unwrap();
        let depths: Vec<f32> = (0..64_u8).map(|i| f32::from(i % 11) / 11.0).collect();
        let map = DepthMap::new(resolution, Slices::Linear, &depths).unwrap();
        let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
        let ray = RayRecord::new(Vec3::splat(1.5), Vec3::Z, 4.0);
        Self {
            dag: dag.upload(gpu).unwrap(),
            voxels: gpu.upload(&[[1, 2, 3, 0]; 2]).unwrap(),
            texels: gpu.upload(&[[1, 2]; 2]).unwrap(),
            boxes: gpu.upload(&[[[1, 2, 3, 0], [4, 4, 4, 0]]; 2]).unwrap(),
            positions: gpu.upload(&[[1.2, 2.3, 3.4, 0.0]; 2]).unwrap(),
            rays: gpu.upload(&[ray; 2]).unwrap(),
            words: gpu.zeros(2).unwrap(),
            shares: gpu.zeros(2).unwrap(),
            intervals: gpu.zeros(8).unwrap(),
        }
    }

    fn run<E: Encode>(&mut self, gpu: &Gpu<E>) -> Vec<Outcome> {
        use shadow_dag::Query;
        let size = FilterSize::new(3).unwrap();
        let (dag, words, shares) = (&self.dag, &mut self.words, &mut self.shares);
        vec![
            outcome("is_lit", gpu.is_lit(dag, &self.voxels, words)),
            outcome("count_lit", gpu.count_lit(dag, size, &self.voxels, words)),
            outcome("filter", gpu.filter(dag, size, &self.voxels, shares)),
            outcome(
                "filter_bilinear",
                gpu.filter_bilinear(dag, size, &self.positions, shares),
            ),
            outcome("depth", gpu.depth(dag, &self.texels, words)),
            outcome(
                "visibility of boxes",
                gpu.visibility(dag, &self.boxes, words),
            ),
            outcome("lit_length", gpu.lit_length(dag, &self.rays, shares)),
            outcome(
                "lit_intervals of a graph",
                gpu.lit_intervals(dag, &self.rays, &mut self.intervals, words),
            ),
        ]
    }
}

struct Curves {
    lists: SegmentLists<GpuMemory>,
    texels: GpuBuffer<u32>,
    numbers: GpuBuffer<f32>,
    map: TransmittanceMap<GpuMemory>,
    receivers: GpuBuffer<Receiver>,
    answers: GpuBuffer<f32>,
}

impl Curves {
    fn new(gpu: &Gpu<Queued>) -> Self {
        let segment = BlockerSegment::from_optical_depth(1.0, 2.0, 0.5).unwrap();
        let receiver = Receiver {
            position: [1.0, 1.0],
            depth: 1.5,
        };
        Self {
            lists: Lists::new([2, 2], &[0, 1, 1, 1, 2], &[segment; 2])
                .and_then(|lists| lists.upload(gpu))
                .unwrap(),
            texels: gpu.upload(&[0, 3, 3]).unwrap(),
            numbers: gpu
                .upload(&[1.0, 2.0, 0.5, 3.0, 3.0, 1.0, 1.0, 1.5, 0.1])
                .unwrap(),
            map: TransmittanceMap::new(gpu, [2, 2]).unwrap(),
            receivers: gpu.upload(&[receiver; 2]).unwrap(),
            answers: gpu.zeros(2).unwrap(),
        }
    }

    fn run<E: Encode>(&mut self, gpu: &Gpu<E>) -> Vec<Outcome> {
        let (texels, numbers) = (&self.texels, &self.numbers);
        let captured: Result<SegmentLists<_, 1>, _> =
            gpu.capture_segments([2, 2], texels, numbers, 2, Order::FrontToBack);
        let clear = Stream::<8>::new();
        let built = gpu.build_map(&clear, &self.lists, &mut self.map);
        let map: &TransmittanceMap<_, Packed<8>> = &self.map;
        let asked = gpu.query_map(map, &self.receivers, Filter::Bilinear, &mut self.answers);
        vec![
            outcome("capture_segments", captured.map(drop)),
            outcome("build_map", built),
            outcome("query_map", asked),
        ]
    }
}
