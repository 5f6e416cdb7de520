"""The paper study: figures and claims of the paper, computed anew."""
