// The end of a curve where there is nothing to choose from. Needs the part
// curve.wgsl.

// Leaves avsm_NODES nodes.
fn avsm_finish(curve: ptr<function, avsm_Curve>) {
    avsm_reduce(curve, avsm_NODES);
}
