"""Training against closed forms, scipy's least squares, and networks planted in the data."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares, minimize

from meshmark.network.perceptron import Perceptron
from meshmark.research.training.levenberg_marquardt import Normal, levenberg_marquardt
from meshmark.research.training.losses import Objective, logistic, squares
from tests.counting import Share, some


def residual_problem(residual, jacobian):
    def expand(x):
        r, j = residual(x), jacobian(x)
        return Normal(loss=0.5 * float(r @ r), gradient=j.T @ r, hessian=j.T @ j)

    return (lambda x: 0.5 * float(residual(x) @ residual(x))), expand


def objective(network, data, targets, loss=squares, ridge=0.0, gain=None, shares=None):
    ones = np.ones(len(data))
    return Objective(
        network=network,
        loss_of=loss,
        inputs=data,
        gain=ones if gain is None else gain,
        targets=targets,
        shares=ones if shares is None else shares,
        ridge=ridge,
    )


def test_a_linear_problem_is_solved_as_by_lstsq():
    rng = np.random.default_rng(0)
    matrix, target = rng.normal(size=(30, 5)), rng.normal(size=30)
    loss, expand = residual_problem(lambda x: matrix @ x - target, lambda _: matrix)
    found = levenberg_marquardt(loss, expand, np.zeros(5), tolerance=0.0)
    np.testing.assert_allclose(found.weights, np.linalg.lstsq(matrix, target)[0], atol=1e-8)


def test_the_bent_valley_of_rosenbrock():
    loss, expand = residual_problem(
        lambda x: np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]]),
        lambda x: np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]]),
    )
    found = levenberg_marquardt(loss, expand, np.array([-1.2, 1.0]), tolerance=0.0)
    np.testing.assert_allclose(found.weights, [1.0, 1.0], atol=1e-9)


def test_an_exponential_fit_ends_where_scipy_ends():
    rng = np.random.default_rng(3)
    t = np.linspace(0.0, 4.0, 60)
    y = 2.5 * np.exp(-1.3 * t) + 0.5 + 0.02 * rng.normal(size=60)

    def residual(x):
        return x[0] * np.exp(-x[1] * t) + x[2] - y

    def jacobian(x):
        fall = np.exp(-x[1] * t)
        return np.column_stack([fall, -x[0] * t * fall, np.ones_like(t)])

    start = np.array([1.0, 0.3, 0.0])
    oracle = least_squares(residual, start, jacobian, xtol=1e-14, ftol=1e-14, gtol=1e-14)
    found = levenberg_marquardt(*residual_problem(residual, jacobian), start, tolerance=0.0)
    np.testing.assert_allclose(found.weights, oracle.x, rtol=1e-6)
    assert found.loss == pytest.approx(oracle.cost, rel=1e-10)


def test_a_planted_network_is_recovered_exactly():
    rng = np.random.default_rng(11)
    data = rng.normal(size=(400, 2))
    drawn = Perceptron.drawn(data, (3,), rng)
    planted = drawn.with_weights(rng.normal(size=len(drawn.weights)) * 1.5)
    with Share(0.25) as share:
        for seed in range(4):  # some starts end in a local minimum
            start = Perceptron.drawn(data, (3,), np.random.default_rng(seed))
            goal = objective(start, data, planted(data))
            found = levenberg_marquardt(goal.loss, goal.expand, start.weights, passes=400, tolerance=0.0)
            share.case()
            if found.loss < 1e-20:
                share.asserted()
                fresh = rng.normal(size=(50, 2))
                np.testing.assert_allclose(
                    start.with_weights(found.weights)(fresh), planted(fresh), atol=1e-7
                )


def test_derivatives_of_the_objective_are_those_of_differences():
    rng = np.random.default_rng(2)
    data, gain = rng.normal(size=(5000, 3)), rng.normal(size=5000)
    network = Perceptron.drawn(data, (4, 2), rng)
    weights = rng.normal(size=len(network.weights))
    for loss, targets in ((squares, rng.normal(size=5000)), (logistic, rng.choice([-1.0, 1.0], 5000))):
        goal = objective(network, data, targets, loss, 0.01, gain, rng.uniform(size=5000))
        normal = goal.expand(weights)
        assert normal.loss == pytest.approx(goal.loss(weights), rel=1e-13)
        for column, change in some(enumerate(np.eye(len(weights)) * 1e-5)):
            slope = (goal.loss(weights + change) - goal.loss(weights - change)) / 2e-5
            assert normal.gradient[column] == pytest.approx(slope, rel=1e-5, abs=1e-8)
        np.testing.assert_array_equal(normal.hessian, normal.hessian.T)
        assert np.linalg.eigvalsh(normal.hessian).min() > 0.0


def test_logistic_training_of_a_linear_network_is_logistic_regression():
    rng = np.random.default_rng(4)
    data = rng.normal(size=(300, 3))
    targets = np.where(
        rng.uniform(size=300) < 1.0 / (1.0 + np.exp(-data @ [1.0, -2.0, 0.5] - 0.3)), 1.0, -1.0
    )
    start = Perceptron.drawn(data, (), rng)
    goal = objective(start, data, targets, logistic, ridge=1e-3)
    found = levenberg_marquardt(goal.loss, goal.expand, start.weights, tolerance=0.0)
    oracle = minimize(
        goal.loss, start.weights, jac=lambda w: goal.expand(w).gradient, method="BFGS", options={"gtol": 1e-9}
    )
    np.testing.assert_allclose(found.weights, oracle.x, atol=1e-6)


def test_training_repeats_to_the_last_bit_and_leaves_its_inputs_alone():
    rng = np.random.default_rng(6)
    data, targets = rng.normal(size=(200, 3)), rng.normal(size=200)
    for part in (data, targets):
        part.setflags(write=False)
    start = Perceptron.drawn(data, (5,), np.random.default_rng(1))
    start.weights.setflags(write=False)
    goal = objective(start, data, targets)
    first, second = (levenberg_marquardt(goal.loss, goal.expand, start.weights, passes=30) for _ in range(2))
    assert (first.weights == second.weights).all()
    assert first.loss < goal.loss(start.weights)


def test_training_stops_where_the_watched_loss_is_least():
    # The loss falls towards 3 while the watched loss is least on the way there, at 1.
    expand = residual_problem(lambda x: 1e-1 * (np.exp(x) - np.exp(3.0)), lambda x: 1e-1 * np.diag(np.exp(x)))
    seen = []

    def watch(x):
        seen.append(x[0])
        return float((x[0] - 1.0) ** 2)

    found = levenberg_marquardt(*expand, np.zeros(1), watch=watch, patience=3, tolerance=0.0)
    best = min(seen, key=lambda x: (x - 1.0) ** 2)
    assert found.weights[0] == best
    assert found.watched == (best - 1.0) ** 2
    assert len(seen) - 1 - seen.index(best) <= 3
    assert found.passes == len(seen) - 1
