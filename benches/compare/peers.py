"""Open3D and GTSAM, each in a process of its own that measures its stages in CPU seconds.

    python peers.py (gtsam | open3d | open3d-register) VARIANT SOURCE RESULT.npz
"""

import itertools
import json
import resource
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from graphs import TRANSLATION_NOISE, kappa_tau, read_g2o, spanning_tree

# Beyond this many standard deviations a measurement counts as an outlier: the scale of Geman-McClure in
# GTSAM, and of the line process in Open3D, which is the same loss.
ROBUST_SCALE = 3.0

NUM_SCANS = 20
VOXEL = 0.05


def scan_files(scene):
    return [Path(scene) / f"cloud_bin_{k}.ply" for k in range(NUM_SCANS)]


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


@contextmanager
def timed(stages, name):
    start = cpu_seconds()
    yield
    stages[name] = stages.get(name, 0.0) + cpu_seconds() - start


def gtsam_sync(source, variant, stages):
    """Chordal initialization and Levenberg-Marquardt, with GTSAM's defaults. `isotropic` weighs the edges
    such that the cost is SE-Sync's objective up to third order; `robust` has Geman-McClure's loss."""
    import gtsam
    with timed(stages, "read"):
        graph, vertices = gtsam.readG2o(source, True)
        ids = sorted(vertices.keys())
        if variant == "isotropic":
            graph = isotropic(source)
        robust = robustified(graph) if variant == "robust" else graph
        anchor = gtsam.noiseModel.Isotropic.Precision(6, 1.0)
        for each in {id(graph): graph, id(robust): robust}.values():
            each.add(gtsam.PriorFactorPose3(ids[0], gtsam.Pose3(), anchor))
    with timed(stages, "solve"):
        start = gtsam.InitializePose3.initialize(graph)
        result = gtsam.LevenbergMarquardtOptimizer(robust, start).optimize()
    poses = [result.atPose3(key) for key in ids]
    return np.array([p.rotation().matrix() for p in poses]), np.array([p.translation() for p in poses])


def isotropic(source):
    """`kappa |R - R'|_F^2 = 2 kappa angle^2 + ...`, and GTSAM halves its squares."""
    import gtsam
    edges, _ = read_g2o(source)
    graph = gtsam.NonlinearFactorGraph()
    for i, j, R, t, kappa, tau in zip(edges.i, edges.j, edges.R, edges.t, *kappa_tau(edges)):
        noise = gtsam.noiseModel.Diagonal.Precisions(np.array([4 * kappa] * 3 + [2 * tau] * 3))
        pose = gtsam.Pose3(gtsam.Rot3(R), t)
        graph.add(gtsam.BetweenFactorPose3(edges.ids[i], edges.ids[j], pose, noise))
    return graph


def robustified(graph):
    import gtsam
    result, loss = gtsam.NonlinearFactorGraph(), gtsam.noiseModel.mEstimator.GemanMcClure.Create(ROBUST_SCALE)
    for factor in map(graph.at, range(graph.size())):
        noise = gtsam.noiseModel.Robust.Create(loss, factor.noiseModel())
        result.add(gtsam.BetweenFactorPose3(*factor.keys(), factor.measured(), noise))
    return result


def open3d_sync(source, variant, stages):
    """Global optimization from a spanning tree; `robust` lets edges that are not in the tree be outliers."""
    with timed(stages, "read"):
        graph, _ = read_g2o(source)
        transformations = np.tile(np.eye(4), (len(graph.i), 1, 1))
        transformations[:, :3, :3], transformations[:, :3, 3] = graph.R, graph.t
        order = [3, 4, 5, 0, 1, 2]  # Open3D has rotations first
        information = graph.information[:, order][:, :, order]
    with timed(stages, "solve"):
        edges = list(zip(graph.i.tolist(), graph.j.tolist(), transformations, information))
        weight = [1.0] * len(edges)
        poses = optimize_globally(len(graph.ids), edges, weight, variant == "robust", ROBUST_SCALE * TRANSLATION_NOISE)
    return poses[:, :3, :3], poses[:, :3, 3]


def optimize_globally(n, edges, weight, robust, distance):
    """Starts at the maximum spanning tree, whose edges are certain."""
    import open3d
    registration = open3d.pipelines.registration
    poses = np.tile(np.eye(4), (n, 1, 1))
    tree = spanning_tree(n, [edge[0] for edge in edges], [edge[1] for edge in edges], weight)
    for k, node in tree:
        i, j, i_from_j, _ = edges[k]
        poses[node] = poses[i] @ i_from_j if node == j else poses[j] @ np.linalg.inv(i_from_j)
    certain = {k for k, _ in tree}
    graph = registration.PoseGraph()
    graph.nodes.extend([registration.PoseGraphNode(pose) for pose in poses])
    for k, (i, j, i_from_j, information) in enumerate(edges):
        uncertain = robust and k not in certain
        graph.edges.append(registration.PoseGraphEdge(j, i, i_from_j, information, uncertain))
    registration.global_optimization(
        graph, registration.GlobalOptimizationLevenbergMarquardt(),
        registration.GlobalOptimizationConvergenceCriteria(),
        registration.GlobalOptimizationOption(max_correspondence_distance=distance, reference_node=0))
    return np.array([node.pose for node in graph.nodes])


def open3d_register(source, _variant, stages):
    """FPFH, RANSAC for all pairs, and global optimization of those that overlap by 30 % or more after it."""
    import open3d
    registration = open3d.pipelines.registration
    open3d.utility.random.seed(0)
    with timed(stages, "reading"):
        clouds = [open3d.io.read_point_cloud(str(path)) for path in scan_files(source)]
    with timed(stages, "features"):
        clouds = [cloud.voxel_down_sample(VOXEL) for cloud in clouds]
        features = [fpfh(cloud) for cloud in clouds]
    edges, overlaps = [], []
    checkers = [registration.CorrespondenceCheckerBasedOnEdgeLength(0.9),
                registration.CorrespondenceCheckerBasedOnDistance(1.5 * VOXEL)]
    for i, j in itertools.combinations(range(len(clouds)), 2):
        with timed(stages, "RANSAC"):
            i_from_j = registration.registration_ransac_based_on_feature_matching(
                clouds[j], clouds[i], features[j], features[i], True, 1.5 * VOXEL,
                registration.TransformationEstimationPointToPoint(), 3, checkers,
                registration.RANSACConvergenceCriteria(100_000, 0.999)).transformation
        with timed(stages, "overlap"):
            overlap = registration.evaluate_registration(clouds[j], clouds[i], 1.4 * VOXEL, i_from_j).fitness
            if overlap >= 0.3:
                information = registration.get_information_matrix_from_point_clouds(
                    clouds[j], clouds[i], 1.4 * VOXEL, i_from_j)
                edges.append((i, j, i_from_j, information))
                overlaps.append(overlap)
    with timed(stages, "global"):
        poses = optimize_globally(len(clouds), edges, overlaps, True, 1.4 * VOXEL)
    return poses[:, :3, :3], poses[:, :3, 3]


def fpfh(cloud):
    import open3d
    cloud.estimate_normals(open3d.geometry.KDTreeSearchParamHybrid(2 * VOXEL, 30))
    cloud.orient_normals_towards_camera_location(np.zeros(3))
    search = open3d.geometry.KDTreeSearchParamHybrid(5 * VOXEL, 100)
    return open3d.pipelines.registration.compute_fpfh_feature(cloud, search)


WORKERS = {"gtsam": gtsam_sync, "open3d": open3d_sync, "open3d-register": open3d_register}


def work(name, variant, source, out):
    stages = {}
    R, t = WORKERS[name](source, variant, stages)
    np.savez(out, R=R, t=t, stages=json.dumps(stages))


if __name__ == "__main__":
    work(*sys.argv[1:])
