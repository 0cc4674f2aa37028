// How a curve is finished without a choice of nodes by dynamic programming. Needs the part
// curve.wgsl.

// Removes the cheapest nodes until at most avsm_NODES are left.
fn avsm_finish(curve: ptr<function, avsm_Curve>) {
    avsm_reduce(curve, avsm_NODES);
}
