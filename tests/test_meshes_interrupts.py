"""Ctrl-C while gmsh asks for sizes: the mesh is made with the right ones, and the interrupt is not lost."""

import os
import signal

import gmsh
import pytest

from meshes import SurfaceGrading, half_disc
from meshes.interrupts import interrupts_wait


def test_an_interrupt_waits_until_the_end():
    reached = []

    def interrupted():
        with interrupts_wait():
            os.kill(os.getpid(), signal.SIGINT)
            reached.append(True)

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert reached == [True]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_interrupt_is_ignored_where_it_was_ignored_before():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interrupts_wait():
            os.kill(os.getpid(), signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)


def test_an_interrupt_inside_the_size_callback_is_not_lost(monkeypatch):
    given = gmsh.model.mesh.setSizeCallback

    def interrupted(callback):
        def ask(*place):
            os.kill(os.getpid(), signal.SIGINT)
            return callback(*place)

        given(ask)

    monkeypatch.setattr(gmsh.model.mesh, "setSizeCallback", interrupted)
    with pytest.raises(KeyboardInterrupt):
        half_disc("body", SurfaceGrading(inner=0.6, outer=1.1, size=0.12, edge_size=0.05, radius=6.0))
