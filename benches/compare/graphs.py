"""Pose graphs: g2o files, SE-Sync's objective, simulation, errors.

Poses are `world_from_node`, as a pair of rotations (n, 3, 3) and translations (n, 3); an edge (i, j)
measures `i_from_j`.
"""

import heapq
from dataclasses import dataclass

import numpy as np

ROTATION_NOISE, TRANSLATION_NOISE = np.radians(2.0), 0.05  # of simulated edges


@dataclass
class Graph:
    ids: list
    i: np.ndarray
    j: np.ndarray
    R: np.ndarray
    t: np.ndarray
    information: np.ndarray  # translation first, as in the file


def rotations(quaternions):
    """Rotation matrices of rows (x, y, z, w)."""
    x, y, z, w = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return np.moveaxis(np.array(rows), 2, 0)


def read_g2o(path):
    """The edges of a g2o file, and the poses of its vertices in the order of their ids."""
    records = [line.split() for line in open(path)]
    vertices = sorted((int(r[1]), [float(x) for x in r[2:9]]) for r in records if r and r[0] == "VERTEX_SE3:QUAT")
    edges = np.array([[float(x) for x in r[1:31]] for r in records if r and r[0] == "EDGE_SE3:QUAT"])
    ids = [vertex for vertex, _ in vertices]
    poses = np.array([pose for _, pose in vertices])
    node = {vertex: k for k, vertex in enumerate(ids)}
    i, j = (np.array([node[int(end)] for end in edges[:, column]]) for column in (0, 1))
    information = np.zeros((len(edges), 6, 6))
    upper = np.triu_indices(6)
    information[:, upper[0], upper[1]] = information[:, upper[1], upper[0]] = edges[:, 9:30]
    graph = Graph(ids, i, j, rotations(edges[:, 5:9]), edges[:, 2:5], information)
    return graph, (rotations(poses[:, 3:]), poses[:, :3])


def kappa_tau(graph):
    """Precisions of rotation and translation per edge, as SE-Sync reads them from a g2o file: the
    isotropic Langevin and Gaussian noise of least divergence, `kappa = 3 / (2 tr inv(rotation))` and
    `tau = 3 / tr inv(translation)`. The rotational block is taken as it stands in the file."""
    trace = lambda blocks: np.trace(np.linalg.inv(blocks), axis1=1, axis2=2)
    return 1.5 / trace(graph.information[:, 3:, 3:]), 3.0 / trace(graph.information[:, :3, :3])


def objective(graph, poses):
    """SE-Sync's objective, `sum kappa |R_j - R_i R_ij|_F^2 + tau |t_j - t_i - R_i t_ij|^2`, without a
    factor 1/2: with this convention the certified minima of OPTIMA come out."""
    (R, t), (kappa, tau) = poses, kappa_tau(graph)
    Ri = R[graph.i]
    rotation = np.sum((R[graph.j] - Ri @ graph.R) ** 2, axis=(1, 2))
    translation = np.sum((t[graph.j] - t[graph.i] - np.einsum("eab,eb->ea", Ri, graph.t)) ** 2, axis=1)
    return kappa @ rotation + tau @ translation


def spanning_tree(n, i, j, weight):
    """Edges of the maximum spanning forest with the nodes they reach, roots first (Prim). Of equal
    weights the one nearer to the root is taken."""
    neighbors = [[] for _ in range(n)]
    for edge, (a, b) in enumerate(zip(i, j)):
        neighbors[a].append((edge, b))
        neighbors[b].append((edge, a))
    reached, tree = [False] * n, []
    for root in range(n):
        heap = [] if reached[root] else [(0.0, 0, -1, root)]
        while heap:
            _, depth, edge, node = heapq.heappop(heap)
            if reached[node]:
                continue
            reached[node] = True
            if edge >= 0:
                tree.append((edge, node))
            for k, other in neighbors[node]:
                if not reached[other]:
                    heapq.heappush(heap, (-weight[k], depth + 1, k, other))
    return tree


def quaternion_product(a, b):
    """Products of rows (x, y, z, w)."""
    (av, aw), (bv, bw) = ((q[:, :3], q[:, 3:]) for q in (a, b))
    return np.hstack([aw * bv + bw * av + np.cross(av, bv), aw * bw - np.sum(av * bv, axis=1, keepdims=True)])


def simulate(n, outliers, path, degree=10, extent=10.0, seed=0):
    """Writes a g2o file of nodes in a cube, joined with near ones as scans that overlap: the Euclidean
    spanning tree and the shortest of the remaining pairs. Returns the rotations of the ground truth.
    Of all edges, the tree among them, the ratio `outliers` is uniformly random; the others have the noise above."""
    rng = np.random.default_rng(seed)
    unit = lambda rows: rows / np.linalg.norm(rows, axis=1, keepdims=True)
    q, t = unit(rng.normal(size=(n, 4))), rng.uniform(-extent / 2, extent / 2, (n, 3))
    distance = lambda a: np.linalg.norm(t - t[a], axis=1)
    near = [np.argpartition(distance(a), 2 * degree + 4)[:2 * degree + 5] for a in range(n)]
    pairs = np.array(sorted({(min(a, b), max(a, b)) for a in range(n) for b in near[a].tolist() if a != b}))
    length = np.linalg.norm(t[pairs[:, 0]] - t[pairs[:, 1]], axis=1)
    tree = [edge for edge, _ in spanning_tree(n, *pairs.T.tolist(), -length)]
    others = np.setdiff1d(np.argsort(length), tree, assume_unique=True)
    i, j = pairs[np.concatenate([tree, others])[:n * degree // 2]].T
    noise = rng.normal(size=(len(i), 3)) * ROTATION_NOISE
    angle = np.linalg.norm(noise, axis=1, keepdims=True)
    noise_rotation = np.hstack([np.sin(angle / 2) * noise / angle, np.cos(angle / 2)])
    inverse = q[i] * [-1, -1, -1, 1]
    q_ij = quaternion_product(quaternion_product(inverse, q[j]), noise_rotation)
    t_ij = np.einsum("eab,eb->ea", rotations(inverse), t[j] - t[i]) + rng.normal(size=(len(i), 3)) * TRANSLATION_NOISE
    outlier = rng.choice(len(i), round(outliers * len(i)), replace=False)
    q_ij[outlier] = unit(rng.normal(size=(len(outlier), 4)))
    t_ij[outlier] = rng.uniform(-extent, extent, (len(outlier), 3))
    diagonal = np.diag([TRANSLATION_NOISE ** -2] * 3 + [ROTATION_NOISE ** -2] * 3)
    information = " ".join(f"{x:.9g}" for x in diagonal[np.triu_indices(6)])
    with open(path, "w") as file:
        file.writelines(f"VERTEX_SE3:QUAT {k} 0 0 0 0 0 0 1\n" for k in range(n))
        for k in rng.permutation(len(i)):
            pose = " ".join(f"{x:.12g}" for x in [*t_ij[k], *q_ij[k]])
            file.write(f"EDGE_SE3:QUAT {i[k]} {j[k]} {pose} {information}\n")
    return rotations(q)


def nearest_rotation(matrix):
    u, _, vt = np.linalg.svd(matrix)
    return u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt


def angles(a, b):
    """Angles between rotation matrices, in degrees: `|A - B|_F = 2 sqrt(2) sin(angle / 2)`."""
    chord = np.linalg.norm(a - b, axis=(-2, -1))
    return np.degrees(2 * np.arcsin(np.minimum(chord / np.sqrt(8), 1)))


def rotation_errors(estimated, ground_truth):
    """Angles to the ground truth in degrees, in the common frame of least absolute error (Weiszfeld)."""
    offsets = ground_truth @ np.swapaxes(estimated, 1, 2)
    frame = nearest_rotation(offsets.mean(axis=0))
    for _ in range(100):
        weight = 1 / np.maximum(np.linalg.norm(offsets - frame, axis=(1, 2)), 1e-9)
        frame = nearest_rotation(np.einsum("n,nab->ab", weight, offsets))
    return angles(offsets, frame)
