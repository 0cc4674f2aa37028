// Airlight by quadrature with the nodes of `nodes.wgsl`.

// Airlight per unit of σ_s I, in 1/(m sr): 0 for an empty segment, air_FAR for one that
// meets the light.
fn air_quadrature_airlight(sigma_t: f32, segment: air_Segment) -> f32 {
    var nodes = air_nodes_of(air_scaled(sigma_t, segment), segment, air_Pattern());
    if nodes.part.kind != air_ORDINARY {
        return select(0.0, air_FAR, nodes.part.kind == air_MEETS_LIGHT);
    }
    let quadrature = air_quadrature_uniforms();
    var sum = 0.0;
    loop {
        let node = air_next_scaled_node(&nodes);
        if node.done {
            break;
        }
        let phase = air_phase(
            quadrature.phase_kind,
            quadrature.phase_parameters,
            node.one_minus_cos,
            node.one_plus_cos,
        );
        sum += air_exp2_times(node.weight * phase, -air_LOG2_E * node.depth, 0);
    }
    return air_exp2_times(sum, -nodes.part.octaves, -nodes.part.exponent);
}
