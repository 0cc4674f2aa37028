//! Airlight evaluators with a shader part.

use gpu_backend::gpu::Argument;

use crate::airlight::{EquiAngular, Midpoint};

/// An airlight evaluator that brings its part of a shader.
pub trait WgslAirlight {
    /// WGSL that defines
    /// `fn light_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32>`,
    /// the radiance from an interval that is lit. Its bindings are in
    /// `@group(2)`.
    fn parts() -> &'static [&'static str];

    /// Values of `override` constants.
    fn constants(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// What is bound to `@group(2)`.
    fn arguments(&self) -> Vec<Argument<'_>>;
}

impl WgslAirlight for Midpoint {
    fn parts() -> &'static [&'static str] {
        &[include_str!("midpoint.wgsl")]
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

impl WgslAirlight for EquiAngular {
    fn parts() -> &'static [&'static str] {
        &[
            include_str!("quadrature.wgsl"),
            include_str!("quadrature_bindings.wgsl"),
        ]
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let nodes: Vec<[f32; 2]> = self.rule().iter().map(|(t, w)| [*t, *w]).collect();
        vec![Argument::uniform(self.nodes()), Argument::table(&nodes)]
    }
}
