"""Fields of a finite-element result: VTU files for ParaView, pictures of meshes and stress."""
