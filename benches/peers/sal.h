// The source annotations that DirectXMath's headers use, as nothing. Microsoft's own sal.h comes with their compilers only.
#pragma once

#define _Analysis_assume_(expression)
#define _In_
#define _In_reads_(size)
#define _In_reads_bytes_(size)
#define _Out_
#define _Out_opt_
#define _Out_writes_(size)
#define _Out_writes_bytes_(size)
#define _Out_writes_opt_(size)
#define _Success_(expression)
#define _Use_decl_annotations_
