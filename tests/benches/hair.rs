//! Hair that is seen: finding its strands, the curves of its pixels, and its light on every
//! backend; time per fragment, beside a copy of the same number of sums.

use std::hint::black_box;
use std::time::Duration;

use crepuscular_tests::suite;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use gpu_backend::{Cpu, Download};
use lighting::hair::{AddHairLight, Fibre, HairMemory, LitHair, SeenHair};
use lighting::methods::exact::UploadedTracer;
use lighting::scene::Media;
use lighting::scene::procedural::Embedded;
use lighting::scene::view::View;
use lighting::translucent::{Casters, TransmittanceMap};
use reference::scenes::TestScene;
use transmittance::{Packed, Stream};

/// The size of the picture.
const SIZE: [u32; 2] = [240, 135];

/// Texels per side of a map.
const MAP: u32 = 256;

/// A picture of hair.
struct Stand {
    scene: TestScene,
    view: View,
    seen: SeenHair,
}

impl Stand {
    fn light<B>(
        &self,
        criterion: &mut Criterion,
        backend: &B,
        tracer: &<B::Memory as HairMemory<Packed<8>>>::Tracer,
        maps: &[TransmittanceMap<B::Memory>],
    ) where
        B: AddHairLight<Packed<8>> + Download,
    {
        let Self { scene, view, seen } = self;
        let lights: Vec<_> = scene.emitters.iter().zip(maps).collect();
        let media = Media::new(Some(&scene.medium), None, &scene.translucent);
        let lit = LitHair {
            view,
            translucent: &scene.translucent,
            media: &media,
            tracer,
            lights: &lights,
            fibre: Fibre::default(),
        };
        let mut radiance = backend.zeros(scene.rays.len()).expect("memory");
        let mut group = criterion.benchmark_group("hair");
        group.throughput(Throughput::Elements(seen.len() as u64));
        group.bench_function(format!("light/{}", backend.name()), |bencher| {
            bencher.iter(|| {
                backend
                    .add_hair_light(seen, &lit, &mut radiance)
                    .expect("sums of the picture");
                backend.wait().expect("a backend that works");
            });
        });
        group.finish();
    }
}

fn hair(criterion: &mut Criterion) {
    let cpu = Cpu::new();
    let scene = TestScene::new(Embedded::SmokeHair, SIZE[0], SIZE[1]);
    let view = View::new(&cpu, &scene.camera, &scene.tracer, SIZE[0], SIZE[1]);
    let view = view.expect("a size with pixels");
    let find = || SeenHair::new(&cpu, &scene.camera, &view, &scene.translucent);
    let seen = find().expect("strands");
    let casters = Casters::new(&scene.translucent, None);
    let clear = Stream::<8>::new();
    let map = |emitter| TransmittanceMap::build(&cpu, &casters, emitter, MAP, &clear);
    let maps: Result<Vec<TransmittanceMap>, _> = scene.emitters.iter().map(map).collect();
    let maps = maps.expect("memory");

    let mut group = criterion.benchmark_group("hair");
    group.throughput(Throughput::Elements(seen.len() as u64));
    group.bench_function("find", |bencher| bencher.iter(find));
    group.bench_function("cover", |bencher| bencher.iter(|| seen.cover(&cpu)));
    let from = vec![[1.0_f32; 4]; seen.len()];
    let mut to = from.clone();
    group.bench_function("copy", |bencher| {
        bencher.iter(|| black_box(&mut to[..]).copy_from_slice(black_box(&from)));
    });
    group.finish();

    let stand = Stand { scene, view, seen };
    stand.light(criterion, &cpu, &stand.scene.tracer, &maps);
    if let Some(gpu) = suite::gpu() {
        let tracer = UploadedTracer::new(&gpu, &stand.scene.tracer).expect("solid triangles");
        let there = maps.iter().map(|map| map.upload(&gpu));
        let there: Vec<_> = there.collect::<Result<_, _>>().expect("memory");
        stand.light(criterion, &gpu, &tracer, &there);
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    targets = hair
}
criterion_main!(benches);
