//! Airlight evaluators with a shader part.

use airlight::Table;
use airlight::gpu::{NODES, NUMERIC, SCALED, SEGMENT, TABLE};
use gpu_backend::gpu::Argument;

use crate::airlight::{Analytic, EquiAngular, Midpoint, Quadrature};

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
            include_str!("equi_angular.wgsl"),
            include_str!("equi_angular_bindings.wgsl"),
        ]
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let nodes: Vec<[f32; 2]> = self.rule().iter().map(|(t, w)| [*t, *w]).collect();
        vec![Argument::uniform(self.nodes()), Argument::table(&nodes)]
    }
}

impl WgslAirlight for Quadrature {
    fn parts() -> &'static [&'static str] {
        &[
            SEGMENT,
            NUMERIC,
            SCALED,
            NODES,
            include_str!("quadrature.wgsl"),
            include_str!("quadrature_bindings.wgsl"),
            include_str!("quadrature_alone.wgsl"),
        ]
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(self.rule().gpu_uniforms()),
            Argument::table(&self.rule().gpu_entries()),
        ]
    }
}

impl WgslAirlight for Analytic<Table> {
    fn parts() -> &'static [&'static str] {
        &[
            SEGMENT,
            NUMERIC,
            SCALED,
            NODES,
            TABLE,
            include_str!("quadrature.wgsl"),
            include_str!("quadrature_bindings.wgsl"),
            include_str!("analytic.wgsl"),
            include_str!("analytic_bindings.wgsl"),
        ]
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = self.rest().arguments();
        arguments.push(Argument::uniform(self.evaluator().gpu_uniforms()));
        arguments.push(Argument::table(&self.evaluator().gpu_cells()));
        arguments
    }
}
