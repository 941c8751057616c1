"""Who got which copy: a database of originals and of the marked copies that were made of them."""
