// The end of a curve without spare room. Needs the part curve.wgsl.

// Leaves avsm_NODES nodes.
fn avsm_finish(curve: ptr<function, avsm_Curve>) {
    avsm_reduce(curve, avsm_NODES);
}
