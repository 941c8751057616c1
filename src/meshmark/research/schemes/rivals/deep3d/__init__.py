"""Deep 3D mesh watermarking (Wang et al. 2022): a learnt embedder and extractor on the vertices' graph.

The network runs on numpy; PyTorch (`pip install 'meshmark-research[deep]'`) is needed to train it only.
"""
