!> Checks of the model: what records refer to, before anything is meshed; then the size of the mesh
!! and the shape of its elements.
module input_check
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: to_text, quoted, nearest, lower
  use input_contact, only: check_contacts
  use input_draft, only: build_t
  use input_lists, only: MAX_NUMBER
  use input_npatch, only: npatch_name
  use input_rigid, only: check_rigid
  use input_where, only: where_t, unknown_face, W_FACES, W_EDGE, W_GROUP
  use mesh, only: mesh_t, is_rigid
  use mesh_body, only: group_named, group_hint
  use patch_spec, only: GEO_MESH, GEO_SPLINE
  use spline_set, only: check_set
  use tensor, only: det3
  use word_material, only: material_index
  use word_patch, only: patch_named
  implicit none
  private
  public :: check_references, check_size, check_jacobians

contains

  !> Names and numbers that records refer to; errors go to the list.
  subroutine check_references(build)
    type(build_t), intent(inout) :: build
    integer, allocatable :: missing(:)
    integer :: i, j, e, last

    if (build%incomplete) return ! an unknown word may have been the definition
    do i = 1, size(build%patch)
      call check_patch(build, i)
    end do
    do i = 1, size(build%npatch)
      call check_material(build, build%npatch(i)%material, build%npatch(i)%place)
      call check_words(build, build%npatch(i)%material, .true.)
    end do
    allocate (missing(0)) ! materials of ELEMents and BLOCk, each reported once
    last = -1
    do e = 1, build%elements%top
      if (build%elements%nen(e) == 0) cycle
      associate (m => build%elements%material(e))
        if (m == last) cycle
        last = m
        if (material_index(build, m) > 0 .or. any(missing == m)) cycle
        missing = [missing, m]
        call check_material(build, m, build%places%at(build%elements%place(e)))
      end associate
    end do
    do i = 1, build%nsupport
      call check_where(build, build%support(i)%at)
    end do
    do i = 1, build%nmove
      call check_where(build, build%move(i)%at)
    end do
    do i = 1, build%npress
      call check_where(build, build%press(i)%at)
    end do
    do i = 1, build%ncurve
      do j = 1, size(build%curve(i)%column)
        associate (c => build%curve(i)%column(j))
          if (c%at%kind /= 0) call check_where(build, c%at)
          if (allocated(c%body)) call check_name(build, c%body, c%body_place)
        end associate
      end do
    end do
    do i = 1, size(build%contact)
      do j = 1, 2
        call check_where(build, build%contact(i)%at(j))
      end do
    end do
    call check_contacts(build)
    call check_rigid(build)
  end subroutine check_references

  !> Materials, size and NPATch geometry of patch i. Nothing is meshed that a mesh cannot hold; the
  !! nodes of meshes and splines are counted at the end.
  subroutine check_patch(build, i)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: i
    type(error_t), allocatable :: error
    real(wp) :: n
    integer :: j

    associate (p => build%patch(i))
      if (p%spec%type /= 'RIGID') then
        if (p%spec%geometry == GEO_MESH) then
          do j = 1, size(p%mesh%material)
            call check_material(build, p%mesh%material(j)%number, p%mesh%material(j)%place)
            call check_words(build, p%mesh%material(j)%number, .false.)
          end do
          return
        end if
        if (.not. allocated(p%material_place%file)) return ! its own error is in the list
        call check_material(build, p%material, p%material_place)
        call check_words(build, p%material, .false.)
      end if
      n = product(real(p%spec%nelem, wp)*merge(2.0_wp, 1.0_wp, p%spec%type == 'Q2') + 1.0_wp)
      if (n > MAX_NUMBER) then
        call fail(error, DECK_ERROR, 'patch '//quoted(p%spec%name)//' has '//to_text(n)//' nodes', &
                  p%spec%place, 'a mesh has at most '//to_text(MAX_NUMBER)//' nodes')
        call build%errors%add(error)
      end if
      if (p%npatch == 0) return
      if (p%npatch > size(build%npatch)) then
        call fail(error, DECK_ERROR, 'NPATch '//to_text(p%npatch)//' is not defined', &
                  p%npatch_place, 'the deck has '//to_text(size(build%npatch))//' NPATch solids')
        call build%errors%add(error)
      else
        build%npatch(p%npatch)%is_geometry = .true.
      end if
    end associate
  end subroutine check_patch

  subroutine check_material(build, number, place)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: number
    type(place_t), intent(in) :: place
    type(error_t), allocatable :: error
    character(:), allocatable :: hint
    integer :: i

    if (material_index(build, number) > 0) return
    hint = 'the deck has no MATErial'
    if (size(build%model%material) > 0) hint = 'defined:'
    do i = 1, min(size(build%model%material), 20)
      hint = hint//' '//to_text(build%model%material(i)%number)
    end do
    call fail(error, DECK_ERROR, 'material '//to_text(number)//' is not defined', place, hint)
    call build%errors%add(error)
  end subroutine check_material

  !> Fails where a material has words that do not apply to a body; each material once.
  subroutine check_words(build, number, is_npatch)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: number
    logical, intent(in) :: is_npatch !! the body: an NPATch, else a PATCh, MESH or SPLIne
    type(error_t), allocatable :: error
    integer :: m

    m = material_index(build, number)
    if (m == 0) return
    associate (set => build%model%material(m))
      if (set%given_formulation .and. .not. is_npatch) then
        call fail(error, DECK_ERROR, 'material '//to_text(number) &
                  //' has DISPlacement or ENHAnced, but a PATCh uses it', &
                  set%place, 'remove the word: TYPE of the PATCh decides')
      else if (set%enhanced .and. is_npatch) then
        call fail(error, DECK_ERROR, 'material '//to_text(number) &
                  //' is ENHAnced, but an NPATch uses it', &
                  set%place, 'remove the word: only 8-node elements have enhanced modes')
      else if (any(set%nurbs_points > 0) .and. .not. is_npatch) then
        call fail(error, DECK_ERROR, 'material '//to_text(number) &
                  //' has NURB interp, but a PATCh uses it', &
                  set%place, 'remove the word: QUADrature of the PATCh sets the points')
      end if
    end associate
    if (.not. allocated(error)) return
    call build%errors%add(error)
    build%model%material(m)%given_formulation = .false. ! report it once
    build%model%material(m)%enhanced = .false.
    build%model%material(m)%nurbs_points = 0
  end subroutine check_words

  !> The body of a place is known, and so is its face or group.
  subroutine check_where(build, at)
    type(build_t), intent(inout) :: build
    type(where_t), intent(in) :: at
    type(error_t), allocatable :: error
    integer :: p

    if (all(at%kind /= [W_FACES, W_EDGE, W_GROUP])) return
    if (.not. is_known(build, at%body)) then
      call check_name(build, at%body, at%place)
      return
    end if
    p = patch_named(build, at%body)
    if (p > 0) then
      if (build%patch(p)%spec%geometry == GEO_SPLINE .and. at%kind == W_GROUP) then
        call check_set(build%patch(p)%spec%spline%surface, at%body, at%face, at%face_place, error)
        if (allocated(error)) call build%errors%add(error)
        return
      end if
      if (build%patch(p)%spec%geometry /= GEO_MESH) p = 0
    end if
    if (p == 0) then
      if (at%kind == W_GROUP) call unknown_face(at%face, at%face_place, error)
    else if (lower(at%face) /= 'all') then
      associate (mesh => build%patch(p)%mesh)
        if (any(group_named(mesh%file, at%face))) return
        call fail(error, DECK_ERROR, 'mesh '//quoted(at%body)//' has no group ' &
                  //quoted(at%face), at%face_place, group_hint(mesh%file, at%face))
      end associate
    end if
    if (allocated(error)) call build%errors%add(error)
  end subroutine check_where

  !> A patch of that name, or an NPATch.
  logical function is_known(build, name) result(known)
    type(build_t), intent(in) :: build
    character(*), intent(in) :: name
    integer :: i

    known = patch_named(build, name) > 0
    do i = 1, size(build%npatch)
      if (npatch_name(i) == name .and. .not. build%npatch(i)%is_geometry) known = .true.
    end do
  end function is_known

  !> Fails with the nearest name where there is neither a patch nor an NPATch of that name.
  subroutine check_name(build, name, place)
    type(build_t), intent(inout) :: build
    character(*), intent(in) :: name
    type(place_t), intent(in) :: place
    type(error_t), allocatable :: error
    character(len(name) + 64), allocatable :: names(:)
    character(:), allocatable :: hint
    integer :: i

    if (is_known(build, name)) return
    allocate (names(size(build%patch) + size(build%npatch)))
    do i = 1, size(build%patch)
      names(i) = build%patch(i)%spec%name
    end do
    do i = 1, size(build%npatch)
      names(size(build%patch) + i) = npatch_name(i)
    end do
    if (size(names) == 0) then
      hint = 'the deck has no PATCh; NODE n, POINt x y z and PLANe direction coordinate need none'
    else
      hint = 'nearest known: '//nearest(name, names)
    end if
    call fail(error, DECK_ERROR, 'patch '//quoted(name)//' is not defined', place, hint)
    call build%errors%add(error)
  end subroutine check_name

  !> The mesh has elements that are solved for, and not more nodes than can be numbered.
  subroutine check_size(build, mesh)
    type(build_t), intent(inout) :: build
    type(mesh_t), intent(in) :: mesh
    type(error_t), allocatable :: error

    if (.not. any(mesh%used)) then
      call fail(error, DECK_ERROR, 'the mesh has no elements', build%control%place, &
                'add ELEMents, BLOCk, NPATch, PATCh or MESH')
    else if (all(is_rigid(mesh%block))) then
      call fail(error, DECK_ERROR, 'all bodies are rigid', build%control%place, &
                'add a body that can deform')
    else if (mesh%nnode > MAX_NUMBER) then
      call fail(error, DECK_ERROR, 'the mesh has '//to_text(mesh%nnode)//' nodes', &
                build%control%place, 'a mesh has at most '//to_text(MAX_NUMBER)//' nodes')
    end if
    if (allocated(error)) call build%errors%add(error)
  end subroutine check_size

  !> The Jacobian of every element is positive at all its integration points; one message a block.
  subroutine check_jacobians(build, mesh)
    type(build_t), intent(inout) :: build
    type(mesh_t), intent(in) :: mesh
    type(error_t), allocatable :: error
    type(place_t) :: place
    character(:), allocatable :: text, hint
    real(wp), allocatable :: x(:, :)
    real(wp) :: least, worst
    integer :: b, e, q, first, bad

    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b))) cycle
      associate (block => mesh%block(b))
        bad = 0
        first = 0
        worst = 0.0_wp
        do e = 1, block%nelem
          x = mesh%xr(:, block%conn(:, e))
          least = huge(least)
          associate (basis => block%basis(block%ibasis(e)))
            do q = 1, basis%nq
              least = min(least, det3(matmul(x, transpose(basis%dshp(:, :, q)))))
            end do
          end associate
          if (.not. least < huge(least)) least = 0.0_wp ! not a number
          if (least > 0.0_wp) cycle
          bad = bad + 1
          if (first > 0) cycle
          first = e
          worst = least
        end do
        if (bad == 0) cycle
        text = 'element '//to_text(block%number(first))//' is inverted: its Jacobian is ' &
               //to_text(worst)
        if (bad > 1) text = text//' (the first of '//to_text(bad)//' inverted elements)'
        if (block%body > 0) then
          place = mesh%body(block%body)%place
          hint = 'use more elements to follow the shape more closely, or enrich other faces'
        else
          place = build%places%at(build%elements%place(block%number(first)))
          hint = 'number its first four nodes counter-clockwise as seen from the other four'
        end if
      end associate
      call fail(error, DECK_ERROR, text, place, hint)
      call build%errors%add(error)
    end do
  end subroutine check_jacobians

end module input_check
