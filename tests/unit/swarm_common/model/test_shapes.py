import numpy as np

from swarm_common.model.shapes import inverse_of, transform_from_xyz_rpy


def test_a_transform_and_its_inverse_cancel():
    transform = transform_from_xyz_rpy(1.3, -0.7, 0.2, 0.4, -0.5, 2.6)
    np.testing.assert_allclose(inverse_of(transform) @ transform, np.eye(4), atol=1e-15)
