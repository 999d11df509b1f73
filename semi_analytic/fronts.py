from __future__ import annotations

import math

from dataclasses import dataclass, field

import numpy as np
from numpy.polynomial import chebyshev as C

ORDER = 20
_PANELS = (0.0, 0.001, 0.006, 0.03, 0.12, 0.4, 1.0)


def _graded(count=12):
    x, w = np.polynomial.legendre.leggauss(count)
    at = np.concatenate([a + (b - a) * (1 + x) / 2 for a, b in zip(_PANELS[:-1], _PANELS[1:])])
    wt = np.concatenate([(b - a) * w / 2 for a, b in zip(_PANELS[:-1], _PANELS[1:])])
    return at, wt


_V, _VW = _graded()
_PLAIN = (_V / 2, _VW / 2)
_ROOT = (_V**2 / 2, _VW * _V)
_GX, _GW = np.polynomial.legendre.leggauss(32)
_PSI, _PSIW = np.pi * (1 + _GX) / 2, np.pi / 2 * _GW  # for maps with a cosine


def unit_nodes(n):
    return -np.cos(np.pi * np.arange(n + 1) / n)


def clenshaw(coef, number, t):
    """sum coef[number] T_k(t); coef (n+1, pieces)."""
    b1 = np.zeros_like(t)
    b2 = np.zeros_like(t)
    two = 2 * t
    for row in coef[:0:-1]:
        b1, b2 = row[number] + two * b1 - b2, b1
    return coef[0][number] + t * b1 - b2


_FIT = {}


def fit(values):
    """Chebyshev coefficients of values (n+1, ...) at unit_nodes(n)."""
    n = len(values) - 1
    if n not in _FIT:
        _FIT[n] = np.linalg.inv(C.chebvander(unit_nodes(n), n))
    return _FIT[n] @ values


class Piece:
    """s' on [low, high]: a Chebyshev series in theta, x = low + (high - low) sin(theta/2)^2, that resolves roots at both ends."""

    def __init__(self, low, high, g):
        self.low, self.high, self.g = low, high, np.asarray(g)
        n = 2 * len(g) + 8
        theta = np.pi * (unit_nodes(n) + 1) / 2
        slope = fit(C.chebval(unit_nodes(n), g) * (high - low) / 2 * np.sin(theta) * np.pi / 2)
        self.s = C.chebint(slope, lbnd=-1.0)
        self.s0 = 0.0  # s at the low end

    def place(self, x):
        return 4 / np.pi * np.arcsin(np.sqrt(np.clip((x - self.low) / (self.high - self.low), 0, 1))) - 1

    def at(self, x):
        return C.chebval(self.place(x), self.g)

    def s_at(self, x):
        return self.s0 + C.chebval(self.place(x), self.s)


def piece_nodes(low, high, n):
    return low + (high - low) * np.sin(np.pi * (unit_nodes(n) + 1) / 4) ** 2


class Frozen:
    """Pieces of s' side by side."""

    def __init__(self, pieces):
        self.pieces = pieces
        pad = lambda rows, m: np.array([np.concatenate([r, np.zeros(m - len(r))]) for r in rows]).T.copy()
        self.g = pad([p.g for p in pieces], max(len(p.g) for p in pieces))
        self.s = pad([p.s for p in pieces], max(len(p.s) for p in pieces))
        self.low, self.high = np.array([p.low for p in pieces]), np.array([p.high for p in pieces])
        self.length = self.high - self.low
        self.s0 = np.array([p.s0 for p in pieces])
        share, weight = _PLAIN
        theta = np.pi * np.concatenate([share, 1 - share])
        num = np.arange(len(pieces))[:, None] + np.zeros(len(theta), int)
        length = self.length[:, None]
        # distances from both ends, without cancellation
        near = np.sin(np.pi * share / 2) ** 2
        self.up = length * np.concatenate([near, 1 - near])
        self.down = length * np.concatenate([1 - near, near])
        self.y = self.low[:, None] + self.up
        self.wy = length / 2 * np.sin(np.pi * np.concatenate([share, share])) * np.pi * np.concatenate([weight, weight])
        t = np.broadcast_to(2 * theta / np.pi - 1, num.shape)
        self.gy = clenshaw(self.g, num, t)
        self.sy = clenshaw(self.s, num, t) + self.s0[:, None]

    def theta(self, number, x):
        return 2 * np.arcsin(np.sqrt(np.clip((x - self.low[number]) / self.length[number], 0, 1)))

    def nodes(self, b1, b2):
        """Quadrature of [b1, b2] (n,), piece by piece: tuples (rows, y, weight, G, S, y - b1, b2 - y)."""
        b1c, b2c = b1[:, None], b2[:, None]
        inside = (np.minimum(b2c, self.high) > np.maximum(b1c, self.low))
        whole = inside & (b1c <= self.low) & (b2c >= self.high)
        out = []
        k, p = np.nonzero(whole)
        if len(k):
            up = self.up[p] + (self.low[p] - b1[k])[:, None]
            down = self.down[p] + (b2[k] - self.high[p])[:, None]
            out.append((k, self.y[p], self.wy[p], self.gy[p], self.sy[p], up, down))
        k, p = np.nonzero(inside & ~whole)
        if len(k):
            in1, in2 = b1[k] > self.low[p], b2[k] < self.high[p]
            begin = np.where(in1, self.theta(p, b1[k]), 0.0)[:, None]
            end = np.where(in2, self.theta(p, b2[k]), np.pi)[:, None]
            in1, in2 = in1[:, None], in2[:, None]
            span = end - begin
            low_share, high_share = np.where(in1, _ROOT[0], _PLAIN[0]), np.where(in2, _ROOT[0], _PLAIN[0])
            wt = span * np.concatenate([np.where(in1, _ROOT[1], _PLAIN[1]), np.where(in2, _ROOT[1], _PLAIN[1])], axis=1)
            off1 = span * np.concatenate([low_share, 1 - high_share], axis=1)  # theta - begin
            off2 = span * np.concatenate([1 - low_share, high_share], axis=1)  # end - theta
            theta = np.concatenate([begin + span * low_share, end - span * high_share], axis=1)
            length = self.length[p][:, None]
            up = length * np.sin((theta + begin) / 2) * np.sin(off1 / 2)
            down = length * np.sin((theta + end) / 2) * np.sin(off2 / 2)
            y = np.where(in1, b1[k][:, None], self.low[p][:, None]) + up
            up = np.where(in1, up, up + (self.low[p] - b1[k])[:, None])
            down = np.where(in2, down, down + (b2[k] - self.high[p])[:, None])
            num = np.broadcast_to(p[:, None], theta.shape)
            t = 2 * theta / np.pi - 1
            out.append((k, y, wt * length / 2 * np.sin(theta), clenshaw(self.g, num, t), clenshaw(self.s, num, t) + self.s0[num], up, down))
        return out

    def integrals(self, b1, b2, with_s=False):
        """int G/w, int zeta G/w over [b1, b2], (n,) each; (int zeta^2 G/w, int S/w) too if with_s."""
        n = len(b1)
        found = np.zeros((4 if with_s else 2, n))
        for k, y, wt, g, s, up, down in self.nodes(b1, b2):
            w = wt / np.sqrt(up * down)
            z = (up - down) / 2
            found[0] += np.bincount(k, np.sum(w * g, axis=1), n)
            found[1] += np.bincount(k, np.sum(w * z * g, axis=1), n)
            if with_s:
                found[2] += np.bincount(k, np.sum(w * z * z * g, axis=1), n)
                found[3] += np.bincount(k, np.sum(w * s, axis=1), n)
        return found


def root(y, b1, b2):
    return np.sqrt(np.maximum((y - b1[:, None]) * (b2[:, None] - y), 1e-290))


@dataclass
class Hertz:
    A: float
    R: float
    kinks = np.zeros(0)

    def edges(self, P, alpha):
        m, c = -alpha * self.R, np.sqrt(2 * self.A * self.R * P / np.pi)
        return m - c, m + c

    def pressure(self, x, l, r):
        return np.sqrt(np.maximum((x - l) * (r - x), 0.0)) / (self.A * self.R)

    def slope(self, x):
        return x / self.R

    def integrals(self, b1, b2):
        """int h'/w, int zeta h'/w, int zeta^2 h'/w over [b1, b2]."""
        m, c = (b1 + b2) / 2, (b2 - b1) / 2
        return np.pi * m / self.R, np.pi * c**2 / 2 / self.R, np.pi * m * c**2 / 2 / self.R

    def moment(self, l, r, P):
        return P * (l + r) / 2

    def edge_factor(self, x, l, r):
        """p over sqrt((x - l)(r - x)) at an edge."""
        return 1 / (self.A * self.R)


_GROWING = {}


def growing_rule(n):
    """For the nodes k = 1..n of a step: weights (n, m) on [-1, phi_k], cardinal functions (n, m, n + 1), T_j' there, and the
    divided differences of T_j between phi_k and the nodes of the rule, with phi_k - phi."""
    if n not in _GROWING:
        phi_k = unit_nodes(n)[1:]
        length = (phi_k + 1)[:, None]
        # the edge moves as the square of 1 - phi at the end of a step: roots in x are none in phi there
        last = (phi_k == phi_k[-1])[:, None]
        share, weight = np.where(last, _PLAIN[0], _ROOT[0]), np.where(last, _PLAIN[1], _ROOT[1])
        begin = np.broadcast_to(_PLAIN[0], share.shape)
        gap = length * np.concatenate([1 - begin, share], axis=1)
        phi = np.concatenate([-1 + length * begin, phi_k[:, None] - length * share], axis=1)
        wt = length * np.concatenate([np.broadcast_to(_PLAIN[1], share.shape), weight], axis=1)
        vander = C.chebvander(phi, n)
        at = C.chebvander(phi_k, n)
        D = np.zeros((*phi.shape, n + 1))
        D[..., 1] = 1
        for j in range(1, n):
            D[..., j + 1] = 2 * (at[:, None, j] + phi * D[..., j]) - D[..., j - 1]
        slope = np.zeros((n + 1, n + 1))
        for j in range(1, n + 1):
            d = C.chebder(np.eye(n + 1)[j])
            slope[: len(d), j] = d
        _GROWING[n] = wt, vander @ _inverse(n), vander @ slope, D * gap[..., None]
    return _GROWING[n]


def growing_matrices(side, b1, b2):
    """Contribution of s' at node j of a growing piece to int G/w and int zeta G/w at node k: (n, n + 1) each."""
    n = len(b1) - 1
    wt, cards, slope, differ = growing_rule(n)
    edge, far = (b2, b1) if side > 0 else (-b1, -b2)
    series = fit(edge)
    gap = differ @ series  # from the edge
    whole = (edge - far)[1:, None]
    w = (slope @ series) * wt / np.sqrt(gap * (whole - gap))
    z = side * (whole / 2 - gap)
    return np.einsum("ki,kij->kj", w, cards), np.einsum("ki,kij->kj", w * z, cards)


def _inverse(n):
    fit(np.zeros(n + 1))
    return _FIT[n]


class NotFollowed(Exception):
    pass


class State:
    def __init__(self, t, b1, b2, d1, d2, pieces):
        self.t, self.b1, self.b2, self.d1, self.d2 = t, b1, b2, d1, d2
        pieces = trimmed(pieces, b1, b2)
        self.frozen = Frozen(pieces)
        self.low, self.high = self.frozen.low[0], self.frozen.high[-1]

    def end_slope(self, side):
        """s' at the stick edge of this side."""
        piece = self.frozen.pieces[-1 if side > 0 else 0]
        return float(piece.at(self.b2 if side > 0 else self.b1))


def trimmed(pieces, b1, b2):
    """Pieces that reach into [b1, b2]; the outer ones are kept whole."""
    tiny = 1e-11 * (b2 - b1)
    return [p for p in pieces if p.high > b1 + tiny and p.low < b2 - tiny and p.high > p.low + tiny]


def without_slivers(state, side):
    """The state with its stick edge of a side moved to an old edge that lies within 1e-7 of the stick interval inside it.

    Loops that close bring the edge back to where it was; what rounding leaves in between would be a piece of its own.
    """
    near = 1e-7 * (state.b2 - state.b1)
    ends = [float(p.low if side > 0 else p.high) for p in state.frozen.pieces]
    edge = state.b2 if side > 0 else state.b1
    close = [x for x in ends if 0 <= side * (edge - x) < near]
    if not close:
        return state
    x = min(close) if side > 0 else max(close)
    b1, b2 = (state.b1, x) if side > 0 else (x, state.b2)
    return State(state.t, b1, b2, state.d1, state.d2, state.frozen.pieces)


def cut_piece(piece, low, high):
    """The part of a piece between low and high (None: its own end), resampled."""
    low = piece.low if low is None else max(low, piece.low)
    high = piece.high if high is None else min(high, piece.high)
    if (low, high) == (piece.low, piece.high):
        return piece
    new = Piece(low, high, fit(piece.at(piece_nodes(low, high, len(piece.g) - 1))))
    new.s0 = float(piece.s_at(low))
    return new


@dataclass
class Step:
    t0: float
    t1: float
    kinds: tuple  # ("R", +1), ("S", 0), ("A", +1) left, right
    t: np.ndarray
    loads: np.ndarray  # (4, n+1) P, Q, eps, alpha
    rates: np.ndarray
    l: np.ndarray
    r: np.ndarray
    b1: np.ndarray
    b2: np.ndarray
    pieces: list  # frozen during the step, the new ones included
    work: float = 0.0
    wrong: float = 0.0
    U: np.ndarray = None
    mq: np.ndarray = None
    passed: bool = False


class Engine:
    def __init__(self, normal, friction, loads, rates, order=ORDER):
        self.normal, self.f, self.A = normal, friction, normal.A
        self.loads_of, self.rates_of, self.order = loads, rates, order
        self.counts = {"steps": 0, "newton": 0, "tries": 0}

    # ------------------------------------------------------------------ pieces of theory
    def loads(self, t):
        return np.array([np.broadcast_to(v, np.shape(t)) for v in self.loads_of(t)], dtype=float)

    def rates(self, t):
        return np.array([np.broadcast_to(v, np.shape(t)) for v in self.rates_of(t)], dtype=float)

    def zone(self, lo, hi):
        """Nodes (n, m), weights for zones with roots at both ends."""
        half = ((hi - lo) / 2)[:, None]
        return (lo + hi)[:, None] / 2 - half * np.cos(_PSI), half * np.sin(_PSI) * _PSIW

    def residual(self, frozen, load, l, r, b1, b2, d1, d2, extra=None):
        P, Q, eps, al = load
        f, A = self.f, self.A
        d = d2 or d1 or 1
        opposite = d1 * d2 < 0
        m, hf = (b1 + b2) / 2, (b2 - b1) / 2
        g0, g1 = frozen.integrals(b1, b2)
        if extra is not None:
            g0, g1 = g0 + extra[0], g1 + extra[1]
        h0, h1, _ = self.normal.integrals(b1, b2)
        e0 = f * h0 - d * g0 + np.pi * (f * al - d * eps)
        e1 = f * h1 - d * g1 - A * (f * P - d * Q)
        if opposite:
            xi, wt = self.zone(l, b1)
            p = self.normal.pressure(xi, l[:, None], r[:, None])
            z = xi - m[:, None]
            w = np.sqrt(z * z - (hf * hf)[:, None])
            e0 = e0 - 2 * A * f * np.sum(wt * p / w, axis=1)
            e1 = e1 + 2 * A * f * np.sum(wt * p * np.abs(z) / w, axis=1)
        return e0, e1

    def pressure_rate(self, xi, l, r, rate):
        P, _, _, al = rate
        m = (l + r) / 2
        return (P[:, None] / np.pi - al[:, None] / self.A * (xi - m[:, None])) / np.sqrt(np.maximum((xi - l[:, None]) * (r[:, None] - xi), 1e-290))

    def other_zone(self, side, l, r, b1, b2):
        return self.zone(l, b1) if side > 0 else self.zone(b2, r)

    def strength(self, side, d, opposite, rate, l, r, b1, b2):
        """K of q* at the stick edge of this side, (n,): < 0 where it recedes."""
        P, Q, eps, al = rate
        f, hf = self.f, (b2 - b1) / 2
        K = f * P - d * Q - side * np.pi * hf / self.A * (f * al - d * eps)
        if opposite:
            xi, wt = self.other_zone(side, l, r, b1, b2)
            near, far = (b1, b2) if side > 0 else (b2, b1)
            K = K - 2 * f * np.sum(wt * self.pressure_rate(xi, l, r, rate) * np.sqrt((xi - near[:, None]) / (xi - far[:, None])), axis=1)
        return K

    def edge_rates(self, side, d_other, rate, l, r, b1, b2):
        """Strengths of q' and f p' at a contact edge that sticks, (n,) each."""
        P, Q, eps, al = rate
        c = (r - l) / 2
        kp = (P - side * np.pi * c / self.A * al) / np.sqrt(2 * c)
        d = d_other or 1
        K = self.strength(side, d, False, rate, l, r, b1, b2) / np.sqrt(b2 - b1)
        return d * (self.f * kp - K), self.f * kp

    def slip_rate(self, side, d, opposite, x, rate, l, r, b1, b2):
        """d ds/dt at x (n, m) in the slip zone of a side."""
        P, Q, eps, al = rate
        f, A = self.f, self.A
        m, hf = ((b1 + b2) / 2)[:, None], ((b2 - b1) / 2)[:, None]
        z = side * (x - m)
        over = np.maximum(side * (x - (b2 if side > 0 else b1)[:, None]), 0.0)  # z - hf
        w = np.sqrt(over * (over + 2 * hf))
        N, a = (f * P - d * Q)[:, None], side * (f * al - d * eps)[:, None]
        s = a * w - A / np.pi * N * np.arctanh(w / z)
        if opposite:
            xi, wt = self.other_zone(side, l, r, b1, b2)
            zx = side * (xi - m)  # negative
            pr = wt * self.pressure_rate(xi, l, r, rate)
            arg = (hf[:, :, None] ** 2 - zx[:, None, :] * z[:, :, None]) / (hf[:, :, None] * (z[:, :, None] - zx[:, None, :]))
            s = s + 2 * A / np.pi * f * np.einsum("kj,kij->ki", pr, np.arccosh(np.maximum(arg, 1.0)))
        return s

    def shear_in_stick(self, frozen, x, load, l, r, b1, b2, d1, d2, limit=0):
        """q* over w at x (m,) in the stick interval (scalars): q = d (f p - q*)."""
        P, Q, eps, al = load
        f, A = self.f, self.A
        d = d2 or d1 or 1
        x = np.atleast_1d(x)
        F = lambda y, g: f * (self.normal.slope(y) + al) - d * (g + eps)
        gx = self.frozen_slope(frozen, x)
        Fx = F(x, gx)
        total = np.zeros(len(x))
        one = np.array([b1]), np.array([b2])
        for k, y, wt, g, s, up, down in frozen.nodes(*one):
            w = (wt / np.sqrt(up * down)).ravel()
            y, g = y.ravel(), g.ravel()
            gap = y - x[:, None]
            total += np.sum(w * np.where(gap == 0, 0.0, (F(y, g) - Fx[:, None]) / np.where(gap == 0, 1.0, gap)), axis=1)
        total /= np.pi * A
        if d1 * d2 < 0:
            xi, wt = self.zone(np.array([l]), np.array([b1]))
            p = self.normal.pressure(xi, l, r)
            total += 2 * f / np.pi * np.sum(wt * p / np.sqrt((b1 - xi) * (b2 - xi)) / (x[:, None] - xi), axis=1)
        return total

    def frozen_slope(self, frozen, x):
        number = np.clip(np.searchsorted(frozen.high, x), 0, len(frozen.high) - 1)
        x = np.clip(x, frozen.low[number], frozen.high[number])
        return clenshaw(frozen.g, number, 2 * frozen.theta(number, x) / np.pi - 1)

    def slip_slope(self, frozen, side, x, load, l, r, b1, b2, d1, d2):
        """s' at x (m,) in the slip zone of a side, scalars otherwise."""
        P, Q, eps, al = load
        f, A = self.f, self.A
        d = d2 if side > 0 else d1
        F = lambda y, g: f * (self.normal.slope(y) + al) - d * (g + eps)
        edge = b2 if side > 0 else b1
        Fe = F(edge, self.frozen_slope(frozen, np.array([edge]))[0])
        wx = side * np.sqrt((x - b1) * (x - b2))
        total = np.zeros(len(x))
        one = np.array([b1]), np.array([b2])
        for k, y, wt, g, s, up, down in frozen.nodes(*one):
            w = (wt / np.sqrt(up * down)).ravel()
            y, g = y.ravel(), g.ravel()
            total += np.sum(w * (F(y, g) - Fe) / (x[:, None] - y), axis=1)
        if d1 * d2 < 0:
            lo, hi = (l, b1) if side > 0 else (b2, r)
            xi, wt = self.zone(np.array([lo]), np.array([hi]))
            p = self.normal.pressure(xi, l, r)
            wxi = -side * np.sqrt((xi - b1) * (xi - b2))
            total += A * 2 * f * np.sum(wt * p / wxi / (x[:, None] - xi), axis=1)
        hq = Fe + wx / np.pi * total
        return d * (f * (self.normal.slope(x) + al) - hq) - eps

    # ------------------------------------------------------------------ a step
    def receding(self, frozen, load, l, r, start, d1, d2, moving):
        """b1, b2 (n,) for many instants, the moving ones by Newton's method; the others are contact edges."""
        raise NotImplementedError

    def attempt(self, state, kinds, t1):
        n = self.order
        u = np.pi * (unit_nodes(n) + 1) / 2
        t = state.t + (t1 - state.t) * (1 - np.cos(u)) / 2
        t[-1] = t1
        load, rate = self.loads(t), self.rates(t)
        l, r = self.normal.edges(load[0], load[3])
        (k1, d1), (k2, d2) = kinds
        frozen = state.frozen
        self.counts["tries"] += 1
        size = r[0] - l[0]
        sides = []
        nA = (k1 == "A") + (k2 == "A")
        # start: constant edges, or contact edges
        b1 = l.copy() if k1 == "S" else np.full(n + 1, state.b1)
        b2 = r.copy() if k2 == "S" else np.full(n + 1, state.b2)
        # Where a contact edge has just stopped to stick, q* has no root there yet: the stick edge returns at about the speed of
        # the contact edge before.
        if k1 == "R" and not state.d1:
            b1 = b1 + np.maximum(l[0] - l, 0)
        if k2 == "R" and not state.d2:
            b2 = b2 - np.maximum(r - r[0], 0)
        if k1 == "R":
            b1 = np.maximum(b1, l + 0.98 * min(state.b1 - l[0], 1e-2 * size) + 1e-5 * (t - t[0]) / (t[-1] - t[0]) * size)
        if k2 == "R":
            b2 = np.minimum(b2, r - 0.98 * min(r[0] - state.b2, 1e-2 * size) - 1e-5 * (t - t[0]) / (t[-1] - t[0]) * size)
        b1[0], b2[0] = state.b1, state.b2
        span = slice(1, None)
        cut = lambda v: v[..., span]

        def advanced(b1, b2):
            """Edges of kind A from K = 0 beside the other edge."""
            b1, b2 = b1.copy(), b2.copy()
            if not nA:
                return b1, b2
            opposite = d1 * d2 < 0
            def Ks(b1, b2):
                o = []
                if k1 == "A":
                    o.append(self.strength(-1, d1, opposite, cut(rate), cut(l), cut(r), b1, b2))
                if k2 == "A":
                    o.append(self.strength(1, d2, opposite, cut(rate), cut(l), cut(r), b1, b2))
                return np.array(o)
            c1, c2 = b1[1:].copy(), b2[1:].copy()
            for _ in range(30):
                v = Ks(c1, c2)
                h = 1e-6 * size
                if nA == 1:
                    if k1 == "A":
                        J = (Ks(c1 + h, c2)[0] - Ks(c1 - h, c2)[0]) / (2 * h)
                        dd1, dd2 = -v[0] / J, 0.0
                    else:
                        J = (Ks(c1, c2 + h)[0] - Ks(c1, c2 - h)[0]) / (2 * h)
                        dd1, dd2 = 0.0, -v[0] / J
                else:
                    Ja, Jb = (Ks(c1 + h, c2) - Ks(c1 - h, c2)) / (2 * h), (Ks(c1, c2 + h) - Ks(c1, c2 - h)) / (2 * h)
                    det = Ja[0] * Jb[1] - Jb[0] * Ja[1]
                    dd1, dd2 = -(v[0] * Jb[1] - v[1] * Jb[0]) / det, -(Ja[0] * v[1] - Ja[1] * v[0]) / det
                c1, c2 = c1 + dd1, c2 + dd2
                c1 = np.maximum(c1, l[1:] - size) if k1 == "A" else c1
                c2 = np.minimum(c2, r[1:] + size) if k2 == "A" else c2
                if max(np.max(np.abs(dd1)), np.max(np.abs(dd2))) < 1e-12 * size:
                    break
            else:
                return self.failed(16)
            if not (np.all(np.isfinite(c1)) and np.all(np.isfinite(c2))):
                return self.failed(16)
            b1[1:], b2[1:] = c1, c2
            return b1, b2

        grows = [side for side, k in ((-1, k1), (1, k2)) if k in "SA"]
        moves = [side for side, k in ((-1, k1), (1, k2)) if k == "R"]
        firsts = [state.end_slope(side) for side in grows]
        G = np.concatenate([np.full(n, v) for v in firsts]) if grows else np.zeros(0)
        d = d2 or d1 or 1

        def whole(b1, b2, G):
            """Residuals (2n,), the matrix of d residual / d G, all edges."""
            edges = advanced(b1, b2)
            if edges is None:
                return self.failed(16)
            b1, b2 = edges
            low, high = np.maximum(b1, state.b1) if k1 in "SA" else b1, np.minimum(b2, state.b2) if k2 in "SA" else b2
            # frozen pieces reach to where the growing ones begin
            mats, e = [], [0.0, 0.0]
            for i, side in enumerate(grows):
                m0, m1 = growing_matrices(side, b1, b2)
                g = np.concatenate([[firsts[i]], G[i * n : (i + 1) * n]])
                e[0], e[1] = e[0] + m0 @ g, e[1] + m1 @ g
                mats.append(np.concatenate([m0[:, 1:], m1[:, 1:]]))
            e0, e1 = self.residual(frozen, cut(load), cut(l), cut(r), b1[1:], b2[1:], d1, d2, e if grows else None)
            return np.concatenate([e0, e1]) - left, (-d * np.concatenate(mats, axis=1) if mats else None), b1, b2

        # What the step before has left fades over this one: a jump would make a singular s'.
        fade = 1 - (t[1:] - t[0]) / (t[-1] - t[0])
        one = [v[:1] for v in (l, r)] + [np.array([state.b1]), np.array([state.b2])]
        left0, left1 = self.residual(frozen, load[:, :1], *one, d1, d2)
        left = np.concatenate([left0 * fade, left1 * fade])
        last, fresh = math.inf, False
        for iteration in range(25):
            self.counts["newton"] += 1
            found = whole(b1, b2, G)
            if found is None or not np.all(np.isfinite(found[0])):
                return self.failed(16)
            res, mat, c1, c2 = found
            if not moves:
                dG = -np.linalg.solve(mat, res)
                G = G + dG
                b1, b2 = c1, c2
                if iteration or True:
                    break
            if not grows and iteration > 0 and not fresh:
                # Broyden's update of the 2 x 2 matrix of every instant
                (a11, a21), (a12, a22) = cols if moves[0] < 0 else cols[::-1]
                y0, y1 = res[:n] - before[:n], res[n:] - before[n:]
                u1, u2 = done
                norm = np.maximum(u1 * u1 + u2 * u2, 1e-300)
                r0, r1 = (y0 - a11 * u1 - a12 * u2) / norm, (y1 - a21 * u1 - a22 * u2) / norm
                small = norm < (1e-9 * size) ** 2
                r0, r1 = np.where(small, 0, r0), np.where(small, 0, r1)
                a11, a12, a21, a22 = a11 + r0 * u1, a12 + r0 * u2, a21 + r1 * u1, a22 + r1 * u2
                cols = [(a11, a21), (a12, a22)]
            else:
                cols = self.columns(whole, moves, nA, b1, b2, G, res, size, n)
                if cols is None:
                    return self.failed(20)
            before = res
            with np.errstate(all="ignore"):
                if not grows:
                    (a11, a21), (a12, a22) = cols if moves[0] < 0 else cols[::-1]
                    det = a11 * a22 - a12 * a21
                    s1 = -(res[:n] * a22 - res[n:] * a12) / det
                    s2 = -(a11 * res[n:] - a21 * res[:n]) / det
                    steps = {-1: s1, 1: s2}
                else:
                    J = np.concatenate([(np.concatenate([np.diag(cc[0]), np.diag(cc[1])]) if isinstance(cc, tuple) else cc) for cc in cols] + [mat], axis=1)
                    try:
                        step = -np.linalg.solve(J, res)
                    except np.linalg.LinAlgError:
                        return self.failed(24)
                    steps = {side: step[i * n : (i + 1) * n] for i, side in enumerate(moves)}
                    G = G + step[len(moves) * n :]
            if not all(np.all(np.isfinite(s)) for s in steps.values()):
                return self.failed(16)
            o1, o2 = b1.copy(), b2.copy()
            if -1 in steps:
                b1[1:] = np.clip(b1[1:] + steps[-1], np.maximum(l[1:], state.low), None)
            if 1 in steps:
                b2[1:] = np.clip(b2[1:] + steps[1], None, np.minimum(r[1:], state.high))
            if np.any(b2 - b1 <= 0):
                tight = b2 - b1 <= 0
                b1 = np.where(tight, (3 * o1 + o2) / 4, b1)
                b2 = np.where(tight, (3 * o2 + o1) / 4, b2)
            done = b1[1:] - o1[1:], b2[1:] - o2[1:]
            change = max(np.max(np.abs(b1 - o1)), np.max(np.abs(b2 - o2)))
            clipped = [np.max(np.abs(done[i] - steps[side])) > 1e-9 * size for i, side in ((0, -1), (1, 1)) if side in steps]
            fresh = any(clipped)
            if iteration > 7 and change > 1e-3 * size:
                return self.failed(16)
            if fresh:
                if iteration > 12:
                    return self.failed(20)
                continue
            if change < 1e-12 * size or (iteration > 4 and change < 1e-9 * size and change > last / 4):
                break
            if self.verbose > 2:
                print("     newton", iteration, change, np.max(np.abs(res)), int(np.argmax(np.abs(b2 - o2))), int(np.argmax(np.abs(b1 - o1))))
            last = change
        else:
            return self.failed(12)
        if nA:
            b1, b2 = advanced(b1, b2)
        new = []
        for i, side in enumerate(grows):
            g = np.concatenate([[firsts[i]], G[i * n : (i + 1) * n]])
            new.append((side, fit(b2 if side > 0 else -b1), fit(g)))
        return Step(state.t, t1, kinds, t, load, rate, l, r, b1, b2, new)

    def columns(self, whole, moves, nA, b1, b2, G, res, size, n):
        """Derivatives of the residuals by the moving edges, by differences."""
        h = 1e-8 * size
        cols = []
        for side in moves:
            if True:
                q1, q2 = b1.copy(), b2.copy()
                (q2 if side > 0 else q1)[1:] -= side * h
                D = (whole(q1, q2, G)[0] - res) / (-side * h)
                cols.append((D[:n], D[n:]))
        return cols

    def monitors(self, step):
        """Rows (n+1,) that are positive while the kinds of both ends hold: list of (name, side, values)."""
        (k1, d1), (k2, d2) = step.kinds
        opposite = d1 * d2 < 0
        geo = step.l, step.r, step.b1, step.b2
        out = []
        for side, k, d, d_other in ((-1, k1, d1, d2), (1, k2, d2, d1)):
            width = step.r - step.b2 if side > 0 else step.b1 - step.l
            if k == "R":
                out.append(("turn", side, -self.strength(side, d, opposite, step.rates, *geo)))
                out.append(("gone", side, width))
            elif k == "S":
                q, fp = self.edge_rates(side, d_other, step.rates, *geo)
                out.append(("forward", side, fp - q))
                out.append(("reverse", side, fp + q))
            else:
                edge = fit(step.b2 if side > 0 else -step.b1)
                out.append(("back", side, C.chebval(unit_nodes(self.order), C.chebder(edge))))
                out.append(("gone", side, width))
        return out

    # ------------------------------------------------------------------ from step to step
    def after(self, step, state):
        """The state at the end of a step."""
        pieces = list(state.frozen.pieces)
        for side, x, g in step.pieces:
            end = step.b2 if side > 0 else step.b1
            low, high = sorted((float(end[0]), float(end[-1])))
            if high - low <= 1e-13 * (step.b2[0] - step.b1[0]):
                continue
            n = self.order
            at = piece_nodes(low, high, n)
            new = Piece(low, high, fit(C.chebval(inverse(x, side * at) , g)))
            if side > 0:
                head = cut_piece(pieces[-1], None, low)
                new.s0 = float(head.s_at(low))
                pieces[-1:] = [head, new]
            else:
                head = cut_piece(pieces[0], high, None)
                new.s0 = float(head.s_at(high) - C.chebval(1.0, new.s))
                pieces[:1] = [new, head]
        (k1, d1), (k2, d2) = step.kinds
        step.frozen = Frozen(pieces)
        return State(step.t1, float(step.b1[-1]), float(step.b2[-1]), d1, d2, pieces)

    def closed(self, state, side, l, r, load):
        """The state whose slip zone of this side has come to rest: its s' is frozen up to the contact edge."""
        state = without_slivers(state, side)
        pieces = list(state.frozen.pieces)
        n = 2 * self.order
        edge, end = (state.b2, r) if side > 0 else (state.b1, l)
        low, high = min(edge, end), max(edge, end)
        x = piece_nodes(low, high, n)
        G = np.empty(n + 1)
        inner = slice(1, None) if side > 0 else slice(None, -1)
        G[inner] = self.slip_slope(state.frozen, side, x[inner], load, l, r, state.b1, state.b2, state.d1, state.d2)
        G[0 if side > 0 else -1] = state.end_slope(side)
        new = Piece(low, high, fit(G))
        if side > 0:
            head = cut_piece(pieces[-1], None, edge)
            new.s0 = float(head.s_at(edge))
            return State(state.t, state.b1, r, state.d1, 0, [*pieces[:-1], head, new])
        head = cut_piece(pieces[0], edge, None)
        new.s0 = float(head.s_at(edge) - C.chebval(1.0, new.s))
        return State(state.t, l, state.b2, 0, state.d2, [new, head, *pieces[1:]])

    def classify(self, state, span, event):
        """Kinds of both ends just after the time of a state; the state with zones that come to rest closed. event: sides that turn."""
        t = state.t
        l, r = (float(v) for v in self.normal.edges(*self.loads(np.array([t]))[[0, 3], 0]))
        load = self.loads(np.array([t]))[:, 0]
        rate = self.rates(np.array([t + 1e-6 * span]))
        arr = lambda v: np.array([v])
        geo = lambda st: (arr(l), arr(r), arr(st.b1), arr(st.b2))
        kinds = {-1: None, 1: None}
        for _ in range(4):
            changed = False
            for side in (-1, 1):
                d = state.d2 if side > 0 else state.d1
                if not d:
                    continue
                opposite = state.d1 * state.d2 < 0
                K = float(self.strength(side, d, opposite, rate, *geo(state))[0])
                if K < 0 and side not in event:
                    kinds[side] = ("R", d)
                    continue
                edge, end = (state.b2, r) if side > 0 else (state.b1, l)
                x = edge + (end - edge) * np.array([[0.02, 0.3, 0.6, 1.0]])
                v = self.slip_rate(side, d, opposite, x, rate, *geo(state))[0]
                if v[-1] > 0 and self.advance:
                    kinds[side] = ("A", d)
                    continue
                state = self.closed(state, side, l, r, load)
                kinds[side] = None
                changed = True
            if not changed:
                break
        for side in (-1, 1):
            d = state.d2 if side > 0 else state.d1
            if d:
                continue
            d_other = state.d1 if side > 0 else state.d2
            q, fp = (float(v[0]) for v in self.edge_rates(side, d_other, rate, *geo(state)))
            if fp >= 0:
                kinds[side] = ("S", 0) if abs(q) <= fp else ("R", 1 if q > 0 else -1)
            else:
                end = r if side > 0 else l
                dd = d_other or 1
                kq = float(self.shear_in_stick(state.frozen, end, load, l, r, state.b1, state.b2, state.d1, state.d2)[0]) * math.sqrt(state.b2 - state.b1)
                kp = float(self.normal.edge_factor(end, l, r)) * math.sqrt(r - l)
                ratio = dd * (1 - kq / (self.f * kp))
                kinds[side] = ("R", 1 if q > ratio * fp else -1)
        return state, (kinds[-1], kinds[1])

    def run(self, state, end, longest, corners=(), history=None):
        """Steps up to a time; state at its end."""
        steps = [] if history is None else history
        event, trial = set(), longest
        kinds = None
        while state.t < end - 1e-12 * longest:
            if kinds is None:
                state, kinds = self.classify(state, longest, event)
                event = set()
            stops = [c for c in corners if c > state.t + 1e-12 * longest] + [end]
            stop = min(stops)
            t1 = min(stop, state.t + trial)
            if stop - t1 < 0.2 * trial:
                t1 = stop
            start = state
            # a zone that starts from nothing
            d1 = kinds[0][1]
            d2 = kinds[1][1]
            step = self.attempt(start, kinds, t1)
            first, rough = None, math.inf
            if step is not None:
                first = self.first_event(step, start)
                if first is not None and first[1] == "pass":
                    step = self.to_passage(start, kinds, step, first)
                    first = self.first_event(step, start) if step is not None else None
                    t1 = step.t1 if step is not None else t1
            if step is not None:
                rough = max(resolution(v) for v in (step.b1, step.b2, *(C.chebval(unit_nodes(self.order), g) for _, _, g in step.pieces)))
            if step is None or not rough < self.tolerance:
                if self.verbose > 1:
                    print("   retry", state.t, t1, kinds, "none" if step is None else rough, first)
                trial = min(trial, t1 - state.t) / 2
                if trial < 1e-4 * longest:
                    jumped = self.jump(state, kinds, longest, stop)
                    if jumped is not None:
                        step, state = jumped
                        steps.append(step)
                        if self.verbose:
                            print(f"jump to {state.t} {state.b1} {state.b2}")
                        trial = longest / 16
                        continue
                    step = self.hold(state, kinds, longest, stop)
                    if step is not None:
                        steps.append(step)
                        state = State(step.t1, state.b1, state.b2, *(k[1] for k in kinds), state.frozen.pieces)
                        if self.verbose:
                            print(f"hold to {state.t} {state.b1} {state.b2}", step.turned)
                        event = step.turned
                        if event or state.t >= stop:
                            kinds = None
                        trial = longest / 16
                        continue
                if trial < 1e-7 * longest:
                    raise NotFollowed(f"{state.t} {kinds} {state.b1} {state.b2} {None if step is None else rough}")
                continue
            if first is not None and first[0] < t1 - 1e-11 * longest:
                tt, name, side = first
                if tt <= state.t + 1e-9 * longest:
                    tt = state.t + 1e-9 * longest
                step = self.attempt(start, kinds, tt)
                if step is None:
                    trial = min(trial, t1 - state.t) / 2
                    if trial < 1e-7 * longest:
                        raise NotFollowed(f"event {first}")
                    continue
                event = {side} if name == "turn" else set()
            elif step.passed:
                first = (step.t1, "passed", 0)
            finished = first is not None or t1 == stop
            self.steps_done(step, start)
            new = self.after(step, start)
            if self.verbose:
                print(f"{start.t:.6f} -> {step.t1:.6f} {kinds} b {new.b1:.6f} {new.b2:.6f} l {step.l[-1]:.4f} r {step.r[-1]:.4f} pieces {len(new.frozen.pieces)} rough {rough:.1e}", first)
            steps.append(step)
            state = new
            # an end without a zone keeps none
            state.d1, state.d2 = kinds[0][1], kinds[1][1]
            if first is not None and first[1] == "gone":
                if first[2] > 0:
                    state.d2, state.b2 = 0, float(step.r[-1])
                else:
                    state.d1, state.b1 = 0, float(step.l[-1])
            if finished:
                kinds = None
            trial = min(longest, 2 * trial)
        return state, steps

    def first_event(self, step, start):
        """(time, name, side) of the first monitor that turns negative within a step; a passage of an old edge comes before all."""
        first = None
        size = step.r[0] - step.l[0]
        cuts = np.concatenate([start.frozen.high[:-1], self.normal.kinks])
        marks = []
        for side, k in ((-1, step.kinds[0][0]), (1, step.kinds[1][0])):
            if k == "R":
                b = side * (step.b2 if side > 0 else step.b1)
                behind = side * cuts[(side * cuts < b[0] - 1e-8 * size) & (side * cuts > b[-1])]
                marks += [("pass", side, b - side * float(x)) for x in behind if np.max(side * behind) == side * x]
        for name, side, v in [*marks, *self.monitors(step)]:
            bad = np.flatnonzero(v[1:] < 0) + 1
            if not len(bad) or v[bad[0]] > -1e-11 * np.max(np.abs(v)):
                continue
            k = bad[0]
            if name == "pass":
                tt = step.t[k - 1] + (step.t[k] - step.t[k - 1]) * v[k - 1] / (v[k - 1] - v[k])
            else:
                root = first_root(fit(v), k)
                tt = step.t0 + (step.t1 - step.t0) * (1 - math.cos(math.pi * (root + 1) / 2)) / 2
            if first is None or (name == "pass", -tt) > (first[1] == "pass", -first[0]):
                first = (tt, name, side)
                self.mark = v
        return first

    def to_passage(self, start, kinds, step, first):
        """A step that ends where an edge passes an old one."""
        side = first[2]
        v = self.mark
        x = (step.b2 if side > 0 else step.b1)[0] - side * v[0]
        size = step.r[0] - step.l[0]
        lo, hi, flo, fhi = start.t, step.t1, float(v[0]), float(v[-1])
        guess = first[0]
        for turn in range(30):
            new = self.attempt(start, kinds, guess)
            if new is None:
                hi, fhi = guess, None
                guess = (lo + hi) / 2
                continue
            value = side * float((new.b2 if side > 0 else new.b1)[-1] - x)
            if abs(value) < 1e-10 * size:
                new.passed = True
                return new
            if value > 0:
                lo, flo = guess, value
            else:
                hi, fhi = guess, value
            if fhi is None:
                guess = (lo + hi) / 2
            else:
                part = flo / (flo - fhi)
                guess = lo + (hi - lo) * (part if turn % 3 < 2 else 0.5)
            if hi - lo < 1e-13 * abs(step.t1 - start.t):
                return self.failed(16)
        return None

    def hold(self, state, kinds, longest, stop):
        """A short step with edges held, up to a turning point of their loads or the end."""
        (k1, d1), (k2, d2) = kinds
        if (k1, k2) != ("R", "R"):
            return self.failed(12)
        n = self.order
        t1 = min(stop, state.t + 2e-3 * longest)
        for turn in range(2):
            t = state.t + (t1 - state.t) * (1 - np.cos(np.pi * (unit_nodes(n) + 1) / 2)) / 2
            load, rate = self.loads(t), self.rates(t)
            l, r = self.normal.edges(load[0], load[3])
            step = Step(state.t, t1, kinds, t, load, rate, l, r, np.full(n + 1, state.b1), np.full(n + 1, state.b2), [])
            step.frozen, step.turned = state.frozen, set()
            step.held = True
            turns = [(float(np.interp(0, -v, t)), side) for name, side, v in self.monitors(step) if name == "turn" and v[-1] < 0]
            if turns and turn == 0:
                t1 = min(turns)[0]
                sides = {min(turns)[1]}
            elif turn == 1:
                step.turned = sides
                break
            else:
                break
        self.counts["held"] = self.counts.get("held", 0) + 1
        self.steps_done(step, state)
        return step

    def jump(self, state, kinds, longest, stop):
        """A step over the instant at which edges leave a stretch that had no q* left."""
        (k1, d1), (k2, d2) = kinds
        if (k1, k2) != ("R", "R"):
            return self.failed(12)
        high = state.frozen.high[:-1]
        lefts = np.array([state.b1, *[x for x in high if state.b1 < x < state.b2]])
        rights = np.array([state.b2, *[x for x in high[::-1] if state.b1 < x < state.b2]])
        c1, c2 = (v.ravel() for v in np.meshgrid(lefts, rights, indexing="ij"))
        keep = c1 < c2
        c1, c2 = c1[keep], c2[keep]
        order = np.argsort(c1 - c2)[:40]
        c1, c2 = c1[order], c2[order]
        size = state.b2 - state.b1
        inset = 1e-4 * size
        for delta in 10.0 ** np.arange(-9, -2):
            t = state.t + delta * longest
            if t >= stop:
                return self.failed(16)
            load = self.loads(np.full(len(c1), t))
            l, r = self.normal.edges(load[0], load[3])
            b1, b2 = c1 + inset, c2 - inset
            run = lambda b1, b2: self.residual(state.frozen, load, l, r, b1, b2, d1, d2)
            with np.errstate(all="ignore"):
                for _ in range(20):
                    h = 1e-8 * size
                    e0, e1 = run(b1, b2)
                    p0, p1 = run(b1 + h, b2)
                    q0, q1 = run(b1, b2 - h)
                    a11, a21, a12, a22 = (p0 - e0) / h, (p1 - e1) / h, (e0 - q0) / h, (e1 - q1) / h
                    det = a11 * a22 - a12 * a21
                    s1, s2 = -(e0 * a22 - e1 * a12) / det, -(a11 * e1 - a21 * e0) / det
                    s1, s2 = (np.clip(np.nan_to_num(s), -0.1 * size, 0.1 * size) for s in (s1, s2))
                    b1, b2 = np.clip(b1 + s1, state.b1, None), np.clip(b2 + s2, None, state.b2)
                    bad = b2 - b1 < 1e-3 * size
                    b1, b2 = np.where(bad, c1, b1), np.where(bad, c2, b2)
            fits = np.maximum(np.abs(e0) * size, np.abs(e1)) < 1e-8 * self.A * self.f * load[0]
            good = fits & (np.maximum(np.abs(s1), np.abs(s2)) < 1e-9 * size) & ((b1 > state.b1 + 1e-5 * size) | (b2 < state.b2 - 1e-5 * size))
            best = None
            for i in np.flatnonzero(good):
                x = b1[i] + (b2[i] - b1[i]) * np.linspace(0.02, 0.98, 49)
                q = self.shear_in_stick(state.frozen, x, load[:, i], l[i], r[i], b1[i], b2[i], d1, d2)
                if np.min(q) > -1e-3 * np.max(q) and (best is None or b2[i] - b1[i] > best[1] - best[0]):
                    best = float(b1[i]), float(b2[i])
            if best is not None:
                n = self.order
                tt = state.t + (t - state.t) * (1 - np.cos(np.pi * (unit_nodes(n) + 1) / 2)) / 2
                ld, rt = self.loads(tt), self.rates(tt)
                ll, rr = self.normal.edges(ld[0], ld[3])
                step = Step(state.t, t, kinds, tt, ld, rt, ll, rr, np.full(n + 1, best[0]), np.full(n + 1, best[1]), [])
                step.frozen = state.frozen
                step.jump = True
                self.steps_done(step, state)
                new = State(t, *best, d1, d2, state.frozen.pieces)
                return step, new
        return self.failed(8)

    def failed(self, why):
        if self.verbose > 2:
            import sys
            print("failed at line", sys._getframe(1).f_lineno)

    advance = False
    verbose = 0
    tolerance = 1e-9

    def steps_done(self, step, state):
        """Friction work, U and m_q at the nodes of a step."""
        self.counts["steps"] += 1
        n = self.order
        (k1, d1), (k2, d2) = step.kinds
        opposite = d1 * d2 < 0
        geo = step.l, step.r, step.b1, step.b2
        # time weights: dt/dphi
        u = np.pi * (unit_nodes(n) + 1) / 2
        dt = (step.t1 - step.t0) * np.sin(u) * np.pi / 4
        work, wrong = 0.0, 0.0
        for side, d in ((-1, d1), (1, d2)):
            if not d:
                continue
            lo, hi = (step.l, step.b1) if side < 0 else (step.b2, step.r)
            x, wt = self.zone(lo, hi)
            v = self.slip_rate(side, d, opposite, x, step.rates, *geo)
            p = self.normal.pressure(x, step.l[:, None], step.r[:, None])
            rate = self.f * np.sum(wt * p * v, axis=1)
            work += integral(rate * dt)
            wrong += integral(self.f * np.sum(wt * p * np.minimum(v, 0), axis=1) * dt)
        step.work, step.wrong = work, wrong

    def displacement(self, step):
        """U and m_q at the nodes of a step."""
        (k1, d1), (k2, d2) = step.kinds
        P, Q, eps, al = step.loads
        b1, b2, l, r = step.b1, step.b2, step.l, step.r
        m, hf = (b1 + b2) / 2, (b2 - b1) / 2
        g0, g1, g2, s = step.frozen.integrals(b1, b2, True)
        U = s / np.pi + eps * m - self.A / np.pi * Q * np.log(hf / 2)
        mq = m * Q + (g2 + eps * np.pi * hf**2 / 2) / self.A
        for side, d in ((-1, d1), (1, d2)):
            if not d:
                continue
            lo, hi = (l, b1) if side < 0 else (b2, r)
            x, wt = self.zone(lo, hi)
            p = self.normal.pressure(x, l[:, None], r[:, None])
            z = x - m[:, None]
            w = np.sqrt(np.maximum(z * z - (hf**2)[:, None], 1e-290))
            q = wt * p * self.f * d
            U -= self.A / np.pi * np.sum(q * np.arctanh(np.minimum(w / np.abs(z), 1 - 1e-16)), axis=1)
            mq += side * np.sum(q * z * z / w, axis=1)
        return U, mq


def inverse(coef, x):
    """Where a rising series has the values x, on [-1, 1], by bisection and Newton's method."""
    lo, hi = -np.ones(len(x)), np.ones(len(x))
    slope = C.chebder(coef)
    at = np.zeros(len(x))
    for _ in range(100):
        miss = C.chebval(at, coef) - x
        lo, hi = np.where(miss <= 0, at, lo), np.where(miss >= 0, at, hi)
        steep = C.chebval(at, slope)
        new = at - miss / np.where(steep > 0, steep, 1)
        new = np.where((new >= lo) & (new <= hi) & (steep > 0), new, (lo + hi) / 2)
        if np.max(np.abs(new - at)) < 1e-15:
            break
        at = new
    return at


def first_root(coef, k):
    """The root of a series between node k - 1 and node k."""
    n = len(coef) - 1
    nodes = unit_nodes(n)
    lo, hi = nodes[k - 1], nodes[k]
    for _ in range(60):
        mid = (lo + hi) / 2
        if C.chebval(mid, coef) > 0:
            lo = mid
        else:
            hi = mid
    return (lo + hi) / 2


def resolution(values):
    """Last coefficients over the size."""
    c = fit(values)
    return float(np.max(np.abs(c[-2:])))


def integral(values):
    c = fit(values)
    k = np.arange(0, len(c), 2)
    return float(np.sum(c[k] * 2 / (1 - k**2)))
