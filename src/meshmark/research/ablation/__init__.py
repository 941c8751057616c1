"""NCDG-LV with a module taken out and another put in: the paper's ablation, on what each module serves here."""
