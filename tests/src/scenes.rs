//! Embedded scenes made ready for suites and benches.

use gpu_backend::Cpu;
use lighting::procedural::Embedded;
use lighting::scene::{Camera, Geometry, Medium, Scene};
use lighting::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use lighting::trace::Tracer;
use lighting::view::View;
use lighting::voxels::Eye;
use lighting::{Emitter, LightPath, Ray};

use crate::oracle::image::{Options, Reference, reference};

/// A scene, its emitters and the rays of its view.
#[derive(Debug)]
pub struct Stage {
    /// The embedded scene's name.
    pub name: &'static str,
    /// The checked triangles.
    pub geometry: Geometry,
    /// The triangles in their hierarchy.
    pub tracer: Tracer,
    /// All lights.
    pub emitters: Vec<Emitter>,
    /// What fills the air.
    pub medium: Medium,
    /// Where the rays start.
    pub camera: Camera,
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// One per pixel.
    pub rays: Vec<Ray>,
}

impl Stage {
    /// Builds `embedded` with seed 1, seen in `width` × `height` pixels; an
    /// area light becomes about four points.
    ///
    /// # Panics
    /// If the scene is not sound, which its own tests exclude.
    pub fn new(embedded: Embedded, width: u32, height: u32) -> Self {
        let mut scene: Scene = embedded.build(1);
        let geometry = Geometry::new(&scene).expect("a sound scene");
        scene
            .complete(geometry.bounds())
            .expect("a camera and a light");
        scene.fill_with_fog(geometry.bounds()).expect("a medium");
        let tracer = Tracer::new(&geometry);
        let camera = scene.camera.expect("a camera was placed");
        let view = View::new(&Cpu::new(), &camera, &tracer, width, height).expect("a legal size");
        let emitters = scene
            .lights
            .iter()
            .flat_map(|light| light.emitters(4).expect("a sound light"))
            .collect();
        Self {
            name: embedded.name(),
            tracer,
            emitters,
            medium: scene.medium.expect("a medium was placed"),
            camera,
            size: [width, height],
            rays: view.rays().to_vec(),
            geometry,
        }
    }

    /// An embedded scene as far as `coarsest` steps along a ray resolve it.
    ///
    /// An order of convergence is what errors do in the end, when steps are finer
    /// than what they sample. So rays are left out that pass a light closer than
    /// one of the coarsest steps, unless all do.
    pub fn resolvable(embedded: Embedded, width: u32, height: u32, coarsest: u32) -> Self {
        let mut stage = Self::new(embedded, width, height);
        let bounds = stage.geometry.bounds();
        let size = bounds.min().distance(bounds.max());
        let far_enough = |ray: &Ray| {
            stage.emitters.iter().all(|emitter| {
                LightPath::new(ray, emitter, &stage.medium).is_none_or(|path| {
                    matches!(emitter, Emitter::Directional(_))
                        || path.h() * coarsest as f32 > path.span().length().min(10.0 * size)
                })
            })
        };
        let rays: Vec<Ray> = stage.rays.iter().copied().filter(far_enough).collect();
        if !rays.is_empty() {
            stage.rays = rays;
        }
        stage
    }

    /// The reference image of the rays.
    pub fn truth(&self) -> Reference {
        reference(
            &self.rays,
            &self.emitters,
            &self.medium,
            &self.geometry,
            Options::default(),
        )
    }

    /// The shadow maps of all lights.
    ///
    /// # Panics
    /// If they do not fit into memory.
    pub fn maps<B: RenderShadowMap>(
        &self,
        backend: &B,
        resolution: u32,
    ) -> Vec<ShadowMap<B::Memory>> {
        let casters = Casters::upload(backend, &self.geometry).expect("memory");
        let render = |emitter| {
            backend
                .shadow_map(&casters, emitter, resolution)
                .expect("memory")
        };
        self.emitters.iter().map(render).collect()
    }

    /// What voxels are made for.
    pub fn eye(&self) -> Eye {
        Eye::of_camera(&self.camera, self.size, &self.rays, &self.medium)
    }
}
