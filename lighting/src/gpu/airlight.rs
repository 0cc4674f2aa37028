//! Airlight evaluators in shaders.

use airlight::Table;
use airlight::gpu::{NODES, NUMERIC, SCALED, SEGMENT, TABLE};
use gpu_backend::gpu::{Argument, InShader};
use gpu_backend::shader::Part;

use super::AirlightSlot;
use crate::airlight::{Analytic, EquiAngular, Midpoint, Quadrature};

impl InShader<AirlightSlot> for Midpoint {
    fn part() -> Part {
        Part::new("light_midpoint").source(include_str!("midpoint.wgsl"))
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

impl InShader<AirlightSlot> for EquiAngular {
    fn part() -> Part {
        Part::new("light_equi_angular")
            .source(include_str!("equi_angular.wgsl"))
            .uniform("light_node_count", "u32")
            .read("light_nodes", "array<vec2<f32>>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let nodes: Vec<[f32; 2]> = self.rule().iter().map(|(t, w)| [*t, *w]).collect();
        vec![Argument::uniform(self.nodes()), Argument::table(&nodes)]
    }
}

impl InShader<AirlightSlot> for Quadrature {
    fn part() -> Part {
        Part::new("light_quadrature")
            .sources(&[SEGMENT, NUMERIC, SCALED, NODES])
            .source(include_str!("cookie.wgsl"))
            .source(include_str!("quadrature.wgsl"))
            .uniform("light_rules", "air_Quadrature")
            .read("light_rule_entries", "array<vec4<f32>>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(self.rule().gpu_uniforms()),
            Argument::table(&self.rule().gpu_entries()),
        ]
    }
}

impl InShader<AirlightSlot> for Analytic<Table> {
    fn part() -> Part {
        Part::new("light_analytic")
            .with(Quadrature::part())
            .sources(&[TABLE, include_str!("analytic.wgsl")])
            .uniform("light_table", "air_Table")
            .read("light_table_cells", "array<vec4<u32>>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = self.fallback().arguments();
        arguments.push(Argument::uniform(self.evaluator().gpu_uniforms()));
        arguments.push(Argument::table(&self.evaluator().gpu_cells()));
        arguments
    }
}
